/* SPDX-License-Identifier: MIT */
#include "part.h"

#include "api/files/files.h"
#include "api/json/text.h"
#include "api/json/value.h"
#include "api/request/decode.h"
#include "api/request/digest.h"
#include <errno.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define IMPORTER "drape-import"

/* ---- the surface in the request's text, which is known to be JSON ---- */

struct range {
    const char *from, *to;
};

static const char *skip_space(const char *at) {
    return at + strspn(at, " \t\r\n");
}

static const char *skip_string(const char *at) {
    for (at++; *at && *at != '"'; at++)
        at += *at == '\\' && at[1];
    return *at ? at + 1 : at;
}

/* The next member of an object, from behind its brace or the member before; false at the end. */
static bool next_member(const char **at, struct range *key, struct range *value) {
    int depth = 0;
    *at = skip_space(*at);
    if (**at == ',')
        *at = skip_space(*at + 1);
    if (**at != '"')
        return false;
    key->from = *at + 1;
    *at = skip_string(*at);
    key->to = *at - 1;
    value->to = value->from = skip_space(skip_space(*at) + 1);
    do {
        depth += *value->to == '{' || *value->to == '[';
        depth -= *value->to == '}' || *value->to == ']';
        value->to = *value->to == '"' ? skip_string(value->to) : value->to + 1;
    } while (*value->to && (depth > 0 || !strchr(",]} \t\r\n", *value->to)));
    *at = value->to;
    return true;
}

static bool is_key(const struct range *key, const char *name) {
    return (size_t)(key->to - key->from) == strlen(name) &&
           memcmp(key->from, name, strlen(name)) == 0;
}

/* The member of the object at `at`; at its brace, as long as nothing, where there is none. */
static struct range span_of_member(const char *at, const char *name) {
    struct range key, value, found = {at, at};
    for (at = skip_space(at) + 1; next_member(&at, &key, &value);)
        if (is_key(&key, name))
            found = value;
    return found;
}

/* The request, or the drape of a study, with the surface's id in the place of its file and unit. */
static bool name_surface(struct files_bytes *request, const char *id) {
    char *text = realloc(request->data, request->length + 1);
    if (!text)
        return false;
    text[request->length] = '\0';
    request->data = text;
    const char *at, *end = text + request->length;
    struct range key, value,
        surface = span_of_member(span_of_member(text, "drape").from, "surface");
    struct files_bytes named = {.data = malloc(request->length + API_ID_SIZE + 16)};
    if (!named.data)
        return false;
    char *to = mempcpy(named.data, request->data, (size_t)(surface.from - request->data));
    to = stpcpy(stpcpy(stpcpy(to, "{\"id\":\""), id), "\"");
    for (at = surface.from + 1; next_member(&at, &key, &value);)
        if (!is_key(&key, "file") && !is_key(&key, "unit")) {
            *to++ = ',';
            to = mempcpy(to, key.from - 1, (size_t)(value.to - key.from + 1));
        }
    *to++ = '}';
    to = mempcpy(to, surface.to, (size_t)(end - surface.to));
    *to = '\0';
    named.length = (size_t)(to - named.data);
    free(request->data);
    *request = named;
    return true;
}

/* ---- reading the file ---- */

/* By the importer beside this program, or the one that the shell would find. */
static bool run_importer(const char *file, const char *unit, struct files_bytes *surface) {
    char importer[4096];
    char *const words[] = {(char[]){IMPORTER},
                           strdupa(*unit ? "--unit" : "--time"),
                           strdupa(*unit ? unit : "300"),
                           (char[]){"--"},
                           strdupa(file),
                           NULL};
    posix_spawn_file_actions_t actions;
    int ends[2], status = 0;
    pid_t child;
    ssize_t length = readlink("/proc/self/exe", importer, 4000);
    char *slash = length > 0 ? memrchr(importer, '/', (size_t)length) : NULL;
    strcpy(slash ? slash + 1 : importer, IMPORTER);
    if (access(importer, X_OK) != 0)
        strcpy(importer, IMPORTER);
    if (pipe(ends) != 0 || posix_spawn_file_actions_init(&actions) != 0) {
        files_complain("cannot start", strerror(errno));
        return false;
    }
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_addclose(&actions, ends[0]);
    int code = posix_spawnp(&child, importer, &actions, NULL, words, environ);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    FILE *stream = code == 0 ? fdopen(ends[0], "rb") : NULL;
    bool good = stream && files_drain(stream, surface);
    if (stream)
        fclose(stream);
    if (code != 0) {
        close(ends[0]);
        files_complain(IMPORTER, code == ENOENT ? "is needed for STEP and IGES files: apt install "
                                                  "draped-import"
                                                : strerror(code));
        return false;
    }
    while (waitpid(child, &status, 0) < 0 && errno == EINTR)
        continue;
    return good && status == 0;
}

/* A path as seen from the folder of a request, in `arena`; NULL without memory. */
static const char *path_from(const char *request, const char *path, struct arena *arena) {
    const char *slash = request ? strrchr(request, '/') : NULL;
    size_t folder = slash && *path != '/' ? (size_t)(slash - request) + 1 : 0;
    char *joined = arena_take(arena, folder + strlen(path) + 1, 1);
    if (!joined)
        return NULL;
    strcpy(mempcpy(joined, folder ? request : "", folder), path);
    return joined;
}

/* Reads the file that a surface is, checks it and puts its id in its place. A mesh whose unit
 * nobody says is in that of the request, `unit_of`, if it states one. */
static bool resolve_file(const struct json_value *place, const struct json_value *unit_of,
                         const char *folder, struct files_bytes *request,
                         const struct api_limits *limits, struct arena *arena,
                         struct files_bytes *surface, struct api_problem *problem) {
    struct json_value file = value_member(place, "file"), unit = value_member(place, "unit");
    const char *path, *of = "", *text;
    struct api_surface read;
    char id[API_ID_SIZE];
    bool good;
    if (!value_given(&file))
        return true;
    if (!value_string(&file, &path) || (value_given(&unit) && !value_string(&unit, &of)))
        return false;
    if (*of && !file_unit_known(of))
        return value_fault(&unit, "must be one of m, mm, cm, um, in, ft");
    const char *said;
    if (!*of && value_type(unit_of) == VALUE_STRING && value_string(unit_of, &said) &&
        file_unit_known(said))
        of = said;
    const struct file_format *format = file_format_of(path);
    if (!format) {
        char why[FILE_REFUSAL_SIZE];
        file_refuse(path, why);
        return value_fault(&file, "%s", why);
    }
    path = path_from(folder, path, arena);
    if (!path)
        return !api_problem_no_memory(problem, "the file");
    if (format->cad) {
        good = run_importer(path, of, surface);
    } else {
        struct files_bytes bytes = {0};
        good = files_read(path, &bytes) &&
               file_read_mesh(format, bytes.data ? bytes.data : "", bytes.length, of, arena, &text,
                              &surface->length, problem) == API_OK;
        if (good)
            surface->data = strdup(text);
        free(bytes.data);
    }
    return good && surface->data &&
           api_decode_surface(surface->data, surface->length, limits, arena, &read, problem) ==
               API_OK &&
           api_digest_surface(&read, arena, id) && name_surface(request, id);
}

bool part_resolve(struct files_bytes *request, const char *name, const struct api_limits *limits,
                  struct files_bytes *surface, struct api_problem *problem) {
    struct json_tree tree;
    struct arena *arena = arena_new(limits->max_memory);
    bool good = true;
    /* What is wrong with the text is found again, and said, when it is decoded. */
    struct api_problem malformed = {0};
    if (arena && json_tree_parse(&tree, request->data ? request->data : "", request->length, limits,
                                 arena, &malformed) == API_OK) {
        struct json_value root = value_root(&tree), drape = value_member(&root, "drape");
        const struct json_value *owner = value_given(&drape) ? &drape : &root;
        struct json_value place = value_member(owner, "surface");
        struct json_value unit = value_member(owner, "length_unit");
        tree.problem = problem;
        good = resolve_file(&place, &unit, name, request, limits, arena, surface, problem);
        json_tree_free(&tree);
    }
    arena_free(arena);
    return good;
}
