/* SPDX-License-Identifier: MIT */
#include "flags.h"

#include "server/store/store.h"
#include <errno.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#define KIB INT64_C(1024)
#define MIB (KIB * KIB)
#define GIB (KIB * MIB)

/* How a flag's text becomes a value. */
enum kind {
    KIND_TEXT,   /* const char * */
    KIND_COUNT,  /* int64_t within lowest..highest */
    KIND_BYTES,  /* the same; K, M and G multiply by 1024 */
    KIND_CHOICE, /* int64_t: the position among `metavar`'s words, split by '|' */
    KIND_SWITCH  /* bool; no argument on the command line, 0 or 1 in the environment */
};

struct flag {
    const char *name;     /* without the dashes */
    const char *variable; /* of the environment */
    const char *metavar;
    const char *fallback; /* the default, as text; NULL is computed */
    const char *help;
    enum kind kind;
    size_t offset;  /* of the member of struct config */
    int64_t lowest; /* KIND_COUNT and KIND_BYTES */
    int64_t highest;
    const char *limit; /* its name in GET /v1/limits; NULL: it is not there */
};

#define AT(member) offsetof(struct config, member)

static const struct flag flags[] = {
    {"listen", "DRAPED_LISTEN", "ADDR:PORT", "127.0.0.1:8080",
     "address and port to listen on; port 0 picks a free one; [::1]:8080 for IPv6, *:8080 for all "
     "addresses",
     KIND_TEXT, AT(listen), 0, 0, NULL},
    {"data", "DRAPED_DATA", "DIR", "./draped-data",
     "folder of the database; created when it is missing", KIND_TEXT, AT(data), 0, 0, NULL},
    {"store", "DRAPED_STORE", "URL", "",
     "database: sqlite:PATH (default: draped.db in the data folder), or "
     "postgresql://USER@HOST/DATABASE for several machines; give the password by PGPASSWORD or "
     "~/.pgpass",
     KIND_TEXT, AT(store), 0, 0, NULL},
    {"workers", "DRAPED_WORKERS", "N", NULL, "worker processes; default: one per core", KIND_COUNT,
     AT(workers), 1, 1024, NULL},
    {"role", "DRAPED_ROLE", "all|api|worker", "all",
     "api: answer calls; worker: solve drapes, and answer only /healthz, /readyz and /metrics; "
     "all: both",
     KIND_CHOICE, AT(role), 0, 0, NULL},
    {"tokens", "DRAPED_TOKENS", "FILE", "",
     "file of callers and their roles, with lines name:role:hash as draped hash-token prints them; "
     "read again at SIGHUP",
     KIND_TEXT, AT(tokens), 0, 0, NULL},
    {"allow-anonymous", "DRAPED_ALLOW_ANONYMOUS", NULL, "0",
     "accept every caller, also from other machines, when there are no --tokens", KIND_SWITCH,
     AT(allow_anonymous), 0, 0, NULL},
    {"queue-limit", "DRAPED_QUEUE_LIMIT", "N", "10000",
     "most drapes in the queue; more are answered 429", KIND_COUNT, AT(queue_limit), 1, 1000000000,
     "queue_limit"},
    {"max-body", "DRAPED_MAX_BODY", "BYTES", "64M",
     "largest request body; a larger one is answered 413", KIND_BYTES, AT(max_body), KIB, 900 * MIB,
     "max_body"},
    {"max-mesh", "DRAPED_MAX_MESH", "BYTES", "256M",
     "largest mesh to map onto; a larger one is answered 413", KIND_BYTES, AT(max_mesh), KIB,
     900 * MIB, "max_mesh"},
    {"max-bodies", "DRAPED_MAX_BODIES", "BYTES", "320M",
     "most bytes of all request bodies being received at a time; more are answered 503", KIND_BYTES,
     AT(max_bodies), KIB, 1024 * GIB, "max_bodies"},
    {"max-nodes", "DRAPED_MAX_NODES", "N", "4000000", "most nodes of one drape", KIND_COUNT,
     AT(max_nodes), 1, 1000000000, "max_nodes"},
    {"max-variants", "DRAPED_MAX_VARIANTS", "N", "100000",
     "most variants of one study; more are answered 422", KIND_COUNT, AT(max_variants), 1, 10000000,
     "max_variants"},
    {"max-control-points", "DRAPED_MAX_CONTROL_POINTS", "N", "262144",
     "most control points of one surface, at the most 512 x 512", KIND_COUNT,
     AT(max_control_points), 4, 262144, "max_control_points"},
    {"max-elements", "DRAPED_MAX_ELEMENTS", "N", "4000000", "most JSON values in one body",
     KIND_COUNT, AT(max_elements), 16, 1000000000, "max_elements"},
    {"threads-per-job", "DRAPED_THREADS_PER_JOB", "N", "1",
     "threads for one drape; the result does not depend on it", KIND_COUNT, AT(threads_per_job), 1,
     64, "threads_per_job"},
    {"max-depth", "DRAPED_MAX_DEPTH", "N", "32", "deepest nesting of JSON in a request", KIND_COUNT,
     AT(max_depth), 8, 1000, "max_depth"},
    {"job-timeout", "DRAPED_JOB_TIMEOUT", "SECONDS", "600", "longest time for solving one drape",
     KIND_COUNT, AT(job_timeout), 1, 604800, "job_timeout_seconds"},
    {"lease", "DRAPED_LEASE", "SECONDS", "60",
     "seconds without a heartbeat before a job is given to another host", KIND_COUNT, AT(lease), 2,
     3600, NULL},
    {"job-memory", "DRAPED_JOB_MEMORY", "BYTES", "4G", "most memory of one drape or map",
     KIND_BYTES, AT(job_memory), 16 * MIB, 1024 * GIB, "job_memory"},
    {"check-memory", "DRAPED_CHECK_MEMORY", "BYTES", "640M",
     "most memory for reading request bodies and making maps, all together", KIND_BYTES,
     AT(check_memory), 64 * MIB, 1024 * GIB, "check_memory"},
    {"import-timeout", "DRAPED_IMPORT_TIMEOUT", "SECONDS", "120",
     "longest time for importing one CAD file; after it the answer is 422", KIND_COUNT,
     AT(import_timeout), 1, 86400, "import_timeout_seconds"},
    {"check-timeout", "DRAPED_CHECK_TIMEOUT", "SECONDS", "30",
     "longest time for reading one request body; after it the answer is 413", KIND_COUNT,
     AT(check_timeout), 1, 3600, "check_timeout_seconds"},
    {"max-result", "DRAPED_MAX_RESULT", "BYTES", "16G", "largest stored result", KIND_BYTES,
     AT(max_result), MIB, 1024 * GIB, "max_result"},
    {"retention", "DRAPED_RETENTION", "HOURS", "168", "how long results are kept", KIND_COUNT,
     AT(retention), 1, 876000, "retention_hours"},
    {"retention-jobs", "DRAPED_RETENTION_JOBS", "HOURS", NULL,
     "how long the record of an ended drape is kept; not less than --retention; default: four "
     "times "
     "that",
     KIND_COUNT, AT(retention_jobs), 1, 3504000, "retention_jobs_hours"},
    {"retention-bytes", "DRAPED_RETENTION_BYTES", "BYTES", "0",
     "most bytes of all results; beyond it the oldest are removed; 0: no limit", KIND_BYTES,
     AT(retention_bytes), 0, 1024 * 1024 * GIB, "retention_bytes"},
    {"max-connections", "DRAPED_MAX_CONNECTIONS", "N", "4096", "most open connections", KIND_COUNT,
     AT(max_connections), 16, 1000000, "max_connections"},
    {"trusted-proxy", "DRAPED_TRUSTED_PROXY", "ADDR[,...]", "",
     "addresses of proxies whose headers Forwarded and X-Forwarded-For are trusted to name the "
     "caller",
     KIND_TEXT, AT(trusted_proxy), 0, 0, NULL},
    {"owner-queue", "DRAPED_OWNER_QUEUE", "N", NULL,
     "most drapes of one owner in the queue, and no more than it has free places; more are "
     "answered 429; default: half of --queue-limit",
     KIND_COUNT, AT(owner_queue), 1, 1000000000, "owner_queue"},
    {"owner-running", "DRAPED_OWNER_RUNNING", "N", "0",
     "most drapes of one owner that run at a time; 0: no limit", KIND_COUNT, AT(owner_running), 0,
     1000000, "owner_running"},
    {"owner-bytes", "DRAPED_OWNER_BYTES", "BYTES", "0",
     "most stored bytes of one owner; more are answered 429; 0: no limit", KIND_BYTES,
     AT(owner_bytes), 0, 1024 * 1024 * GIB, "owner_bytes"},
    {"owner-connections", "DRAPED_OWNER_CONNECTIONS", "N", NULL,
     "most connections from one address, and no more than are free; default: half of "
     "--max-connections",
     KIND_COUNT, AT(owner_connections), 1, 1000000, "owner_connections"},
    {"owner-streams", "DRAPED_OWNER_STREAMS", "N", NULL,
     "most event streams and waiting calls of one owner; more are answered 429; default: a quarter "
     "of --max-connections",
     KIND_COUNT, AT(owner_streams), 1, 1000000, "owner_streams"},
    {"owner-bodies", "DRAPED_OWNER_BODIES", "BYTES", NULL,
     "most bytes of one owner's request bodies being received at a time (a single one may be "
     "larger); more are answered 429; default: half of --max-bodies",
     KIND_BYTES, AT(owner_bodies), KIB, 1024 * GIB, "owner_bodies"},
    {"public-name", "DRAPED_PUBLIC_NAME", "NAME[,...]", "",
     "host names by which callers reach the service, such as draped.example behind a proxy; "
     "localhost and the address of --listen are always accepted; others are answered 403; *: any",
     KIND_TEXT, AT(public_name), 0, 0, NULL},
    {"cors-origin", "DRAPED_CORS_ORIGIN", "ORIGIN[,...]", "",
     "origins of web pages that may call, such as https://example.com; *: all", KIND_TEXT,
     AT(cors_origin), 0, 0, NULL},
    {"drain-timeout", "DRAPED_DRAIN_TIMEOUT", "SECONDS", "20",
     "time for running drapes to finish at SIGTERM before they go back to the queue", KIND_COUNT,
     AT(drain_timeout), 0, 25, NULL},
    {"log-level", "DRAPED_LOG_LEVEL", "debug|info|warning|error", "info",
     "least severe messages to log", KIND_CHOICE, AT(log_level), 0, 0, NULL},
};

enum { FLAG_COUNT = sizeof flags / sizeof flags[0] };

bool config_report(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fputs("draped: ", stderr);
    vfprintf(stderr, format, arguments);
    fputs("\n", stderr);
    va_end(arguments);
    return false;
}

/* Where a text came from, as messages name it: "--workers", "DRAPED_WORKERS". */
struct origin {
    const char *prefix;
    const char *name;
};

static bool parse_number(const struct flag *flag, struct origin from, const char *text,
                         int64_t *value) {
    char *end = NULL;
    errno = 0;
    long long number = strtoll(text, &end, 10);
    bool plain = end != text && text[0] >= '0' && text[0] <= '9' && errno == 0;
    static const char letters[] = "KMG";
    static const int64_t factors[] = {KIB, MIB, GIB};
    const char *letter = flag->kind == KIND_BYTES && *end && !end[1] ? strchr(letters, *end) : NULL;
    int64_t factor = !*end ? 1 : letter ? factors[letter - letters] : 0;
    if (!plain || factor == 0 || number > INT64_MAX / factor)
        return config_report("%s%s: '%s' is not a number%s", from.prefix, from.name, text,
                             flag->kind == KIND_BYTES ? " of bytes (K, M and G may follow it)"
                                                      : "");
    *value = number * factor;
    if (*value < flag->lowest || *value > flag->highest)
        return config_report("%s%s: %s is out of range; it takes %lld to %lld", from.prefix,
                             from.name, text, (long long)flag->lowest, (long long)flag->highest);
    return true;
}

static void set_integer(struct config *config, const struct flag *flag, int64_t value) {
    memcpy((char *)config + flag->offset, &value, sizeof value);
}

static bool set_value(struct config *config, const struct flag *flag, struct origin from,
                      const char *text) {
    int64_t value = 0;
    bool on = !strcmp(text, "1");
    switch (flag->kind) {
    case KIND_TEXT:
        memcpy((char *)config + flag->offset, &text, sizeof text);
        return true;
    case KIND_SWITCH:
        if (!on && strcmp(text, "0") != 0)
            return config_report("%s%s: '%s' is neither 0 nor 1", from.prefix, from.name, text);
        memcpy((char *)config + flag->offset, &on, sizeof on);
        return true;
    case KIND_CHOICE:
        for (const char *word = flag->metavar; word; value++) {
            size_t width = strcspn(word, "|");
            if (width == strlen(text) && !strncmp(word, text, width)) {
                set_integer(config, flag, value);
                return true;
            }
            word = word[width] ? word + width + 1 : NULL;
        }
        return config_report("%s%s: '%s' is not one of %s", from.prefix, from.name, text,
                             flag->metavar);
    case KIND_COUNT:
    case KIND_BYTES:
        if (!parse_number(flag, from, text, &value))
            return false;
        set_integer(config, flag, value);
        return true;
    }
    return false;
}

static int64_t get_integer(const struct config *config, const struct flag *flag) {
    int64_t value = 0;
    memcpy(&value, (const char *)config + flag->offset, sizeof value);
    return value;
}

/* For commands that use the store alone other settings may make no sense. */
static bool is_wanted(const struct flag *flag, bool store_alone) {
    return !store_alone || flag->offset == AT(data) || flag->offset == AT(store);
}

/* An empty variable is as good as none: that is how files of variables are written. */
bool flags_set_defaults(struct config *config, bool store_alone) {
    bool good = true;
    memset(config, 0, sizeof *config);
    for (size_t k = 0; k < FLAG_COUNT && good; k++) {
        const struct flag *flag = &flags[k];
        if (!is_wanted(flag, store_alone))
            continue;
        const char *text = getenv(flag->variable);
        if (text && text[0])
            good = set_value(config, flag, (struct origin){"", flag->variable}, text);
        else if (flag->fallback)
            good = set_value(config, flag, (struct origin){"--", flag->name}, flag->fallback);
        else
            set_integer(config, flag, FLAGS_UNSET);
    }
    return good;
}

enum flags_taken flags_take(struct config *config, char **argv, int argc, int *at,
                            bool store_alone) {
    const char *argument = argv[*at];
    if (strncmp(argument, "--", 2) != 0)
        return FLAGS_OTHER;
    /* The flag of "--name" or "--name=value". */
    const char *name = argument + 2;
    size_t length = strcspn(name, "=");
    const char *value = name[length] == '=' ? name + length + 1 : NULL;
    const struct flag *flag = NULL;
    for (size_t k = 0; k < FLAG_COUNT && !flag; k++)
        if (strlen(flags[k].name) == length && !strncmp(flags[k].name, name, length))
            flag = &flags[k];
    if (!flag || !is_wanted(flag, store_alone))
        return FLAGS_OTHER;
    if (flag->kind == KIND_SWITCH)
        value = value ? value : "1";
    else if (!value && *at + 1 < argc)
        value = argv[++*at];
    if (!value)
        config_report("--%s needs a value: %s", flag->name, flag->metavar);
    bool taken = value && set_value(config, flag, (struct origin){"--", flag->name}, value);
    return taken ? FLAGS_TAKEN : FLAGS_BAD;
}

void flags_help(FILE *out) {
    for (size_t k = 0; k < FLAG_COUNT; k++) {
        const struct flag *flag = &flags[k];
        int n = fprintf(out, "  --%s%s%s", flag->name, flag->metavar ? " " : "",
                        flag->metavar ? flag->metavar : "");
        fprintf(out, "%*s%s", n < FLAGS_HELP_COLUMN ? FLAGS_HELP_COLUMN - n : 2, "", flag->help);
        if (flag->fallback && flag->fallback[0] && flag->kind != KIND_SWITCH)
            fprintf(out, " [%s]", flag->fallback);
        fprintf(out, " (%s)\n", flag->variable);
    }
}

void flags_print(const struct config *config, FILE *out) {
    for (size_t k = 0; k < FLAG_COUNT; k++) {
        const struct flag *flag = &flags[k];
        const char *text = NULL;
        if (flag->kind == KIND_TEXT) {
            memcpy(&text, (const char *)config + flag->offset, sizeof text);
            fprintf(out, "%s = %s\n", flag->name, store_url_remote(text) ? "(hidden)" : text);
        } else if (flag->kind == KIND_SWITCH) {
            fprintf(out, "%s = %d\n", flag->name, *((const char *)config + flag->offset));
        } else if (flag->kind == KIND_CHOICE) {
            const char *word = flag->metavar;
            for (int64_t value = get_integer(config, flag); value > 0; value--)
                word = strchr(word, '|') + 1;
            fprintf(out, "%s = %.*s\n", flag->name, (int)strcspn(word, "|"), word);
        } else {
            fprintf(out, "%s = %lld\n", flag->name, (long long)get_integer(config, flag));
        }
    }
}

char *config_limits_json(const struct config *config) {
    char *json = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&json, &size);
    if (!out)
        return NULL;
    const char *separator = "{";
    for (size_t k = 0; k < FLAG_COUNT; k++) {
        if (!flags[k].limit)
            continue;
        fprintf(out, "%s\"%s\":%lld", separator, flags[k].limit,
                (long long)get_integer(config, &flags[k]));
        separator = ",";
    }
    fputs("}", out);
    bool good = !ferror(out);
    if (fclose(out) != 0 || !good) {
        free(json);
        return NULL;
    }
    return json;
}
