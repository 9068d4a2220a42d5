/* SPDX-License-Identifier: MIT */
#include "config.h"
#include "flags.h"
#include "log.h"
#include "server/http/origin.h"
#include "server/http/owner.h"
#include "server/http/tokens.h"
#include "server/store/store.h"
#include "systemd.h"
#include <arpa/inet.h>
#include <limits.h>
#include <netdb.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Numbers only: a name would have to be looked up, and may have several addresses. */
static bool parse_listen(struct config *config) {
    char host[INET6_ADDRSTRLEN + 2];
    const char *colon = strrchr(config->listen, ':');
    size_t length = colon ? (size_t)(colon - config->listen) : 0;
    const char *digits = colon ? colon + 1 : "";
    char *end = NULL;
    unsigned long port = strtoul(digits, &end, 10);
    struct sockaddr_in v4 = {.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
    struct sockaddr_in6 v6 = {.sin6_family = AF_INET6, .sin6_port = htons((uint16_t)port)};
    if (length < sizeof host && digits[0] >= '0' && digits[0] <= '9' && !*end &&
        port <= UINT16_MAX) {
        memcpy(host, config->listen, length);
        host[length] = '\0';
        if (!strcmp(host, "localhost"))
            memcpy(host, "127.0.0.1", sizeof "127.0.0.1");
        if (!strcmp(host, "*")) {
            /* Any address of this machine, of IPv6 too where the kernel has it. */
            int probe = socket(AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0);
            length = (size_t)snprintf(host, sizeof host, "%s", probe < 0 ? "0.0.0.0" : "[::]");
            if (probe >= 0)
                close(probe);
            snprintf(config->listen_name, sizeof config->listen_name, "%s%s", host, colon);
            config->listen = config->listen_name;
        }
        bool six = length > 2 && host[0] == '[' && host[length - 1] == ']';
        if (six)
            host[length - 1] = '\0';
        void *bytes = six ? (void *)&v6.sin6_addr : (void *)&v4.sin_addr;
        if (inet_pton(six ? AF_INET6 : AF_INET, host + six, bytes) == 1) {
            config->loopback =
                six ? IN6_IS_ADDR_LOOPBACK(&v6.sin6_addr) : ntohl(v4.sin_addr.s_addr) >> 24 == 127;
            config->address_length = six ? sizeof v6 : sizeof v4;
            memcpy(&config->address, six ? (void *)&v6 : (void *)&v4, config->address_length);
            return true;
        }
    }
    return config_report(
        "--listen: '%s' is not ADDR:PORT, such as 127.0.0.1:8080, [::1]:8080 or *:8080",
        config->listen);
}

/* The address of the socket that was handed over, in place of --listen. */
static bool take_inherited(struct config *config) {
    const char *why = NULL;
    char port[8];
    char host[INET6_ADDRSTRLEN];
    socklen_t length = sizeof config->address;
    if (!systemd_socket(&config->inherited, &why))
        return config_report("%s", why);
    struct sockaddr *address = (struct sockaddr *)&config->address;
    if (config->inherited < 0)
        return true;
    if (getsockname(config->inherited, address, &length) != 0 ||
        getnameinfo(address, length, host, sizeof host, port, sizeof port,
                    NI_NUMERICHOST | NI_NUMERICSERV) != 0)
        return config_report("the address of the inherited socket cannot be read");
    snprintf(config->listen_name, sizeof config->listen_name,
             address->sa_family == AF_INET6 ? "[%s]:%s" : "%s:%s", host, port);
    config->listen = config->listen_name;
    return true;
}

/* A URL or a path, which has a slash; not a bare word, which may be meant for anything, nor the
 * `keyword=value` form of libpq, which may hold a password. */
static bool check_store(const struct config *config) {
    const char *text = config->store;
    size_t word = strspn(text, "abcdefghijklmnopqrstuvwxyz_");
    word += strspn(text + word, " ");
    return !text[0] || store_url_remote(text) || (!strncmp(text, "sqlite:", 7) && text[7]) ||
           (strchr(text, '/') && !strstr(text, "://") && text[word] != '=') ||
           config_report("--store: give sqlite:PATH, a path with a slash, or "
                         "postgresql://USER@HOST/DATABASE");
}

static bool check_config(struct config *config) {
    if (config->retention_jobs < config->retention)
        return config_report("--retention-jobs: %lld hours are less than --retention, %lld",
                             (long long)config->retention_jobs, (long long)config->retention);
    if (!take_inherited(config) || !parse_listen(config))
        return false;
    if (!config->loopback && !config->allow_anonymous && !config->tokens[0])
        return config_report(
            "--listen: %s can be reached from other machines: give --tokens to authenticate "
            "callers, or --allow-anonymous to accept everybody",
            config->listen);
    if (config->tokens[0]) {
        char why[TOKENS_WHY_SIZE];
        struct tokens *tokens = tokens_open(config->tokens, why);
        tokens_free(tokens);
        if (!tokens)
            return config_report("--tokens: %s", why);
    }
    if (!origin_are_hosts(config->public_name, false))
        return config_report(
            "--public-name: '%s' is not a list of host names, separated by commas, without ports: "
            "name each, or give * alone for any",
            config->public_name);
    if (!owner_are_addresses(config->trusted_proxy))
        return config_report(
            "--trusted-proxy: '%s' is not a list of addresses, separated by commas",
            config->trusted_proxy);
    if (!origin_are_hosts(config->cors_origin, true))
        return config_report("--cors-origin: '%s' is not a list of origins, separated by commas; "
                             "an origin is such as https://example.com, without a path: name each, "
                             "or give * alone for any",
                             config->cors_origin);
    if (config->max_body > config->max_bodies || config->max_mesh > config->max_bodies)
        return config_report(
            "--max-bodies: %lld bytes are less than --%s: such a body could never be received",
            (long long)config->max_bodies,
            config->max_body > config->max_bodies ? "max-body" : "max-mesh");
    if (!config->data[0])
        return config_report("--data is empty");
    /* A variable that a secret leaves empty would make a database of its own of each host. */
    if (config->role != CONFIG_ROLE_ALL && !config->store[0] && getenv("DRAPED_STORE"))
        return config_report(
            "DRAPED_STORE is empty: with --role api or worker set it to the database "
            "that the hosts share");
    return check_store(config);
}

void config_help(FILE *out) {
    fputs("usage: draped [FLAG...]\n"
          "       draped hash-token NAME read|write|admin [--generate]\n"
          "       draped backup FOLDER [--keep N] [--data DIR] [--store URL]\n"
          "       draped restore FILE|FOLDER [--data DIR] [--store URL]\n"
          "       draped status [--data DIR] [--store URL]\n"
          "       draped check [--data DIR] [--store URL]\n\n"
          "Drapes woven fabrics over surfaces, as a service over HTTP.\n\n",
          out);
    flags_help(out);
    fprintf(out, "  --%-*s%s\n", FLAGS_HELP_COLUMN - 4, "check-config", "check the flags and stop");
    fprintf(out, "  --%-*s%s\n", FLAGS_HELP_COLUMN - 4, "healthcheck",
            "ask the daemon that listens at --listen; exit 0 if it is well");
    fprintf(out, "  --%-*s%s\n", FLAGS_HELP_COLUMN - 4, "version", "print the version and stop");
    fprintf(out, "  --%-*s%s\n", FLAGS_HELP_COLUMN - 4, "help", "print this and stop");
    fputs("\nWith --tokens every call needs 'Authorization: Bearer TOKEN', except for the page,\n"
          "/healthz, /readyz, /version, /v1/openapi.json and /v1/limits. The role read sees the\n"
          "drapes and surfaces of its name; write also makes and deletes them; admin does so with\n"
          "those of everybody, and sees /metrics, as every token does from this machine.\n",
          out);
}

/* --help and its like, wherever they stand. */
static bool asks_for(int argc, char **argv, const char *what) {
    for (int k = 1; k < argc; k++)
        if (!strcmp(argv[k], what))
            return true;
    return false;
}

enum config_verdict config_parse(int argc, char **argv, struct config *config) {
    if (asks_for(argc, argv, "--help")) {
        config_help(stdout);
        return CONFIG_DONE;
    }
    if (asks_for(argc, argv, "--version")) {
        puts("draped " DRAPE_VERSION);
        return CONFIG_DONE;
    }
    if (!flags_set_defaults(config, false))
        return CONFIG_BAD;
    bool only_check = false;
    bool probe = false;
    for (int k = 1; k < argc; k++) {
        if (!strcmp(argv[k], "--check-config"))
            only_check = true;
        else if (!strcmp(argv[k], "--healthcheck"))
            probe = true;
        else {
            enum flags_taken taken = flags_take(config, argv, argc, &k, false);
            if (taken == FLAGS_OTHER && strstr(argv[k], "://")) /* which may hold a password */
                config_report("there is an argument that is not a flag; see draped --help");
            else if (taken == FLAGS_OTHER)
                config_report("'%s' is not a flag; see draped --help", argv[k]);
            if (taken != FLAGS_TAKEN)
                return CONFIG_BAD;
        }
    }
    /* What follows from other flags where nothing is given: an owner's share of each limit, and the
     * retention of records, which by default outlive their results to answer 410. */
    const struct {
        int64_t *share, of, divisor;
    } shares[] = {{&config->owner_queue, config->queue_limit, 2},
                  {&config->owner_connections, config->max_connections, 2},
                  {&config->owner_streams, config->max_connections, 4},
                  {&config->owner_bodies, config->max_bodies, 2}};
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    if (config->workers == FLAGS_UNSET)
        config->workers = cores < 1 ? 1 : cores > 1024 ? 1024 : cores;
    for (size_t k = 0; k < sizeof shares / sizeof *shares; k++)
        if (*shares[k].share == FLAGS_UNSET)
            *shares[k].share = (shares[k].of + shares[k].divisor - 1) / shares[k].divisor;
    if (config->retention_jobs == FLAGS_UNSET)
        config->retention_jobs = 4 * config->retention;
    if (!check_config(config))
        return CONFIG_BAD;
    if (probe)
        return CONFIG_PROBE;
    if (only_check)
        flags_print(config, stdout);
    return only_check ? CONFIG_DONE : CONFIG_RUN;
}

bool config_store_url(const struct config *config, char url[PATH_MAX]) {
    int length = config->store[0] ? snprintf(url, PATH_MAX, "%s", config->store)
                                  : snprintf(url, PATH_MAX, "%s/draped.db", config->data);
    return length < PATH_MAX ||
           config_report("the name of the %s is too long", config->store[0] ? "store" : "folder");
}

struct api_limits config_limits(const struct config *config, int threads) {
    return (struct api_limits){
        .max_nodes = (size_t)config->max_nodes,
        .max_memory = (size_t)config->job_memory,
        .max_elements = (size_t)config->max_elements,
        .max_control_points = (size_t)config->max_control_points,
        .max_depth = (int)config->max_depth,
        .threads = threads,
        .max_variants = (size_t)config->max_variants,
    };
}

int config_parse_store(int argc, char **argv, struct config *config, char **rest) {
    int count = 0;
    if (!flags_set_defaults(config, true))
        return -1;
    for (int k = 0; k < argc; k++) {
        enum flags_taken taken = flags_take(config, argv, argc, &k, true);
        if (taken == FLAGS_BAD)
            return -1;
        if (taken == FLAGS_OTHER)
            rest[count++] = argv[k];
    }
    return check_store(config) ? count : -1;
}
