/* SPDX-License-Identifier: MIT */
/* The command line `drape`, run as a user would. The program is the one beside the tests' folder
 * (BUILD/drape for BUILD/tests/unit/test_command); without it the tests are skipped. */
#include "support.h"
#include "tests/check.h"

#include <fcntl.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum { ARGUMENTS_MAX = 12 };

static char program[4096];
static char folder[] = "/tmp/drape-test-XXXXXX";

/* What one run left. */
struct outcome {
    int status; /* exit status; 128 + number when a signal ended it */
    struct bytes out, err;
};

static int find_program(void **state) {
    (void)state;
    ssize_t length = readlink("/proc/self/exe", program, sizeof program - 16);
    check_above(length, 0);
    program[length] = '\0';
    for (int k = 0; k < 3; k++)
        *strrchr(program, '/') = '\0';
    strcat(program, "/drape");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state) {
    (void)state;
    return rmdir(folder);
}

static const char *in_folder(const char *name) {
    static char path[64];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

/* A temporary file that is gone when closed, with this text in it. */
static FILE *stream_of(const char *text) {
    FILE *stream = tmpfile();
    assert_non_null(stream);
    fputs(text, stream);
    rewind(stream);
    return stream;
}

static struct bytes drain(FILE *stream) {
    struct bytes bytes = {0};
    int c;
    rewind(stream);
    bytes_add(&bytes, "", 0);
    while ((c = fgetc(stream)) != EOF)
        bytes_add(&bytes, &(char){(char)c}, 1);
    fclose(stream);
    return bytes;
}

static void need_program(void) {
    if (access(program, X_OK) != 0)
        skip();
}

/* Runs `drape` with these arguments (words between spaces) and standard input. */
static struct outcome run(const char *words, const char *input) {
    char copy[512], *arguments[ARGUMENTS_MAX] = {program}, *rest = NULL;
    size_t count = 1;
    need_program();
    snprintf(copy, sizeof copy, "%s", words);
    for (char *word = strtok_r(copy, " ", &rest); word; word = strtok_r(NULL, " ", &rest))
        arguments[count++] = word;
    FILE *in = stream_of(input), *out = tmpfile(), *err = tmpfile();
    assert_true(count < ARGUMENTS_MAX && out && err);
    pid_t child = fork();
    if (child == 0) {
        dup2(fileno(in), STDIN_FILENO);
        dup2(fileno(out), STDOUT_FILENO);
        dup2(fileno(err), STDERR_FILENO);
        execv(program, arguments);
        _exit(127);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    fclose(in);
    return (struct outcome){WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
                            drain(out), drain(err)};
}

static void outcome_free(struct outcome *outcome) {
    bytes_free(&outcome->out);
    bytes_free(&outcome->err);
}

/* Runs and expects this exit status, nothing on stdout, and each of two texts on stderr. */
static void refuse(const char *words, const char *input, int status, const char *first,
                   const char *second) {
    struct outcome outcome = run(words, input);
    if (outcome.status != status || !strstr(outcome.err.data, first) ||
        !strstr(outcome.err.data, second))
        fail_msg("drape %s: exit status %d: %s", words, outcome.status, outcome.err.data);
    assert_int_equal(outcome.out.length, 0);
    outcome_free(&outcome);
}

static void test_command_writes_the_result_document(void **state) {
    (void)state;
    struct outcome outcome = run("", request_text("saddle"));
    assert_int_equal(outcome.status, 0);
    assert_string_equal(outcome.err.data, "");
    json_t *json = json_loads(outcome.out.data, 0, NULL);
    assert_string_equal(json_string_value(json_object_get(json, "status")), "succeeded");
    json_decref(json);
    outcome_free(&outcome);
}

/* All but the time the solve took, which follows the key. */
static void blank_time(struct bytes *text) {
    char *at = strstr(text->data, "\"solve\":");
    assert_non_null(at);
    memmove(at, strchr(at, '}'), strlen(strchr(at, '}')) + 1);
}

static void test_command_reads_a_file_or_a_dash(void **state) {
    (void)state;
    struct outcome file = run("api/examples/saddle.json", "");
    struct bytes text = file_read("api/examples/saddle.json");
    struct outcome dash = run("-", text.data);
    assert_true(file.status == 0 && dash.status == 0);
    blank_time(&file.out);
    blank_time(&dash.out);
    assert_string_equal(file.out.data, dash.out.data);
    bytes_free(&text);
    outcome_free(&file);
    outcome_free(&dash);
}

static void test_command_takes_the_encoders_options(void **state) {
    (void)state;
    struct outcome outcome = run("--format csv --table cells --fields cells.j,cells.shear_deg "
                                 "--precision 3",
                                 request_text("saddle"));
    assert_int_equal(outcome.status, 0);
    assert_memory_equal(outcome.out.data, "j,shear_deg\n", 12);
    for (const char *line = outcome.out.data; (line = strchr(line, '\n')) && line[1]; line++)
        check_below(strcspn(line + 1, "\n"), 16);
    outcome_free(&outcome);
}

/* Half-way between 1e-10 and 4e-10 the others say 2e-10, twice what is there; and k3 is as they
 * say. */
static void test_command_holds_out_the_rows_of_a_table(void **state) {
    (void)state;
    static const char table[] =
        "{\"permeability\":{\"model\":\"table\",\"shear_deg\":[0,20,40],"
        "\"fiber_volume_fraction\":[0.4,0.5],\"k1\":[[1e-10,5e-11],[1e-10,5e-11],[4e-10,2e-10]],"
        "\"k2\":[[1e-10,5e-11],[2.5e-11,1.25e-11],[1e-10,5e-11]],"
        "\"k3\":[[1e-12,5e-13],[1e-12,5e-13],[1e-12,5e-13]]}}";
    static const char expected[] = "without the shear_deg of each line, percent:\n"
                                   "shear_deg       Vf        k1        k2        k3\n"
                                   "       20      0.4   +100.00   +300.00     +0.00\n"
                                   "       20      0.5   +100.00   +300.00     +0.00\n"
                                   "           largest    100.00    300.00      0.00\n"
                                   "               rms    100.00    300.00      0.00\n";
    struct outcome outcome = run("--hold-one-out /dev/stdin", table);
    assert_int_equal(outcome.status, 0);
    assert_int_equal(outcome.out.length, sizeof expected - 1);
    assert_memory_equal(outcome.out.data, expected, sizeof expected - 1);
    outcome_free(&outcome);
    refuse("--hold-one-out /dev/stdin",
           "{\"model\":\"table\",\"shear_deg\":[0],\"k1\":[1e-10],\"k2\":[1e-10],\"k3\":[1e-12]}",
           1, "invalid-request", "to leave out");
}

/* The request is in it as it was understood, with its defaults. */
static void test_command_writes_a_report(void **state) {
    (void)state;
    struct outcome outcome = run("--report --part Wing", request_text("saddle"));
    assert_int_equal(outcome.status, 0);
    assert_memory_equal(outcome.out.data, "<!doctype html>", 15);
    assert_non_null(strstr(outcome.out.data, "<h1>Wing</h1>"));
    assert_non_null(strstr(outcome.out.data, "yarn_path</th><td>&quot;chord&quot;"));
    assert_non_null(strstr(outcome.out.data, "</html>"));
    outcome_free(&outcome);
    refuse("--report --map api/examples/mould.bdf", request_text("saddle"), 2, "html", "--map");
}

static void test_command_says_what_it_is(void **state) {
    (void)state;
    struct outcome help = run("--help", ""), version = run("--version", "");
    assert_true(help.status == 0 && version.status == 0);
    assert_non_null(strstr(help.out.data, "--precision"));
    assert_non_null(strstr(version.out.data, DRAPE_VERSION));
    outcome_free(&help);
    outcome_free(&version);
}

static void test_command_refuses_a_wrong_command_line(void **state) {
    (void)state;
    static const char *const lines[] = {"--bogus",         "--format xml",  "--precision 0",
                                        "--table front",   "--max-nodes 0", "--max-nodes 1x",
                                        "--threads 99999", "--threads",     "one.json two.json"};
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++)
        refuse(lines[i], request_text("saddle"), 2, "drape", "");
}

static void test_command_explains_problems(void **state) {
    (void)state;
    refuse("", "{\"surface\":1,\"fabric\":{\"spacing\":0}}", 1, "invalid-request",
           "/fabric/spacing: ");
    refuse("", "{\n ]", 1, "malformed-json", "line 2");
    refuse("", "[]", 1, "invalid-request", "must be an object");
    refuse("", "", 1, "malformed-json", "empty");
    refuse("missing.json", "", 1, "missing.json", "No such file");
    refuse("--fields nodes.w", request_text("saddle"), 1, "invalid-request", "nodes.w");
    refuse("--max-nodes 5", request_text("saddle"), 1, "invalid-request", "/fabric/spacing: ");
}

static void test_command_writes_a_whole_file(void **state) {
    (void)state;
    char line[128];
    need_program();
    snprintf(line, sizeof line, "--format csv -o %s", in_folder("out"));
    FILE *old = fopen(in_folder("out"), "w");
    fputs("old", old);
    fclose(old);
    chmod(in_folder("out"), 0640);
    struct outcome outcome = run(line, request_text("saddle"));
    struct bytes text = file_read(in_folder("out"));
    struct stat stat_of;
    assert_int_equal(outcome.status, 0);
    assert_int_equal(outcome.out.length, 0);
    assert_memory_equal(text.data, "i,j,u,v", 7);
    assert_int_equal(stat(in_folder("out"), &stat_of), 0);
    assert_int_equal(stat_of.st_mode & 0777, 0640);
    assert_int_equal(unlink(in_folder("out")), 0);
    bytes_free(&text);
    outcome_free(&outcome);
}

/* Nothing new stays behind (the folder can be removed at the end), and what was there stays. */
static void test_command_leaves_no_partial_file(void **state) {
    (void)state;
    char line[128];
    need_program();
    snprintf(line, sizeof line, "--fields nodes.w -o %s", in_folder("out"));
    refuse(line, request_text("saddle"), 1, "nodes.w", "");
    assert_int_not_equal(access(in_folder("out"), F_OK), 0);
    FILE *old = fopen(in_folder("out"), "w");
    fputs("old", old);
    fclose(old);
    refuse(line, request_text("saddle"), 1, "nodes.w", "");
    struct bytes text = file_read(in_folder("out"));
    assert_string_equal(text.data, "old");
    assert_int_equal(unlink(in_folder("out")), 0);
    bytes_free(&text);
}

static void test_command_keeps_what_is_no_regular_file(void **state) {
    (void)state;
    struct stat before, after;
    assert_int_equal(stat("/dev/null", &before), 0);
    struct outcome outcome = run("-o /dev/null", request_text("saddle"));
    assert_int_equal(outcome.status, 0);
    assert_int_equal(stat("/dev/null", &after), 0);
    assert_true(S_ISCHR(after.st_mode) && before.st_rdev == after.st_rdev);
    outcome_free(&outcome);
    refuse("-o /dev/full", request_text("saddle"), 1, "/dev/full", "No space");
    refuse("-o /nowhere/out", request_text("saddle"), 1, "/nowhere/out", "No such file");
}

static void put_file(const char *name, const char *text) {
    FILE *file = fopen(in_folder(name), "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static const char two_triangles[] =
    "GRID,10,,-1.,-1.,0.\nGRID,11,,1.,-1.,0.\nGRID,12,,1.,1.,0.\nGRID,13,,-1.,1.,0.\n"
    "CTRIA3,7,1,10,11,12\nCTRIA3,5,1,10,12,13\nENDDATA\n";

static void test_command_maps_onto_a_mesh(void **state) {
    (void)state;
    char line[256];
    need_program();
    put_file("mesh.bdf", two_triangles);
    put_file("points.JSON", "{\"points\":[[0,0,0],[0.5,0.25,9]]}");
    snprintf(line, sizeof line, "--map %s --format csv --fields id,shear_deg,extrapolated",
             in_folder("mesh.bdf"));
    struct outcome csv = run(line, request_text("saddle"));
    assert_int_equal(csv.status, 0);
    assert_memory_equal(csv.out.data, "id,shear_deg,extrapolated\n7,", 28);
    assert_non_null(strstr(csv.out.data, "\n5,"));
    assert_string_equal(csv.err.data, "");
    snprintf(line, sizeof line, "--map %s --precision 3", in_folder("points.JSON"));
    struct outcome points = run(line, request_text("saddle"));
    json_t *json = json_loads(points.out.data, 0, NULL), *cells = json_object_get(json, "cells");
    assert_int_equal(json_array_size(json_object_get(cells, "distance")), 2);
    assert_int_equal(json_array_size(json_object_get(cells, "warp_x")), 2);
    json_decref(json);
    snprintf(line, sizeof line, "--map %s --format vtu", in_folder("mesh.bdf"));
    struct outcome vtu = run(line, request_text("saddle"));
    assert_int_equal(vtu.status, 0);
    assert_non_null(strstr(vtu.out.data, "UnstructuredGrid"));
    outcome_free(&csv);
    outcome_free(&points);
    outcome_free(&vtu);
    assert_int_equal(unlink(in_folder("mesh.bdf")) | unlink(in_folder("points.JSON")), 0);
}

static void test_command_warns_of_a_mesh_far_away(void **state) {
    (void)state;
    char line[128];
    need_program();
    put_file("far.json", "{\"points\":[[0,0,50]]}");
    snprintf(line, sizeof line, "--map %s", in_folder("far.json"));
    struct outcome outcome = run(line, request_text("saddle"));
    assert_int_equal(outcome.status, 0);
    assert_non_null(strstr(outcome.err.data, "1 of 1 points are further"));
    outcome_free(&outcome);
    assert_int_equal(unlink(in_folder("far.json")), 0);
}

static void test_command_explains_what_is_wrong_with_a_map(void **state) {
    (void)state;
    char line[128];
    need_program();
    refuse("--map missing.bdf", request_text("saddle"), 1, "missing.bdf", "No such file");
    refuse("--inlet 5", request_text("saddle"), 2, "--inlet", "--map");
    refuse("--map x.bdf --format vtp", request_text("saddle"), 2, "vtp", "with --map");
    refuse("--format vtu", request_text("saddle"), 2, "vtu", "");
    put_file("mesh.bdf", two_triangles);
    snprintf(line, sizeof line, "--map %s --format lcmsim", in_folder("mesh.bdf"));
    refuse(line, request_text("saddle"), 1, "invalid-request", "");
    snprintf(line, sizeof line, "--map %s --inlet 6", in_folder("mesh.bdf"));
    refuse(line, request_text("saddle"), 1, "invalid-request", "no element 6");
    put_file("mesh.bdf", "GRID,1,,0.,0.,0.\nCBAR,1,1,1,2\n");
    snprintf(line, sizeof line, "--map %s", in_folder("mesh.bdf"));
    refuse(line, request_text("saddle"), 1, "invalid-request", "beside 1 GRIDs it has 1 CBAR");
    assert_int_equal(unlink(in_folder("mesh.bdf")), 0);
    put_file("points.json", "{\"points\":[[0,0,0]]}");
    snprintf(line, sizeof line, "--map %s --format vtu", in_folder("points.json"));
    refuse(line, request_text("saddle"), 1, "not-acceptable", "vtu needs elements");
    assert_int_equal(unlink(in_folder("points.json")), 0);
}

/* ---- studies ---- */

static struct bytes study_of(const char *rest) {
    struct bytes text = {0};
    bytes_format(&text, "{\"drape\":%s,\"objectives\":[\"max_shear_deg\"],%s}",
                 request_text("saddle"), rest);
    return text;
}

/* The document of all variants, the table of the best, and the request of one, which drapes. */
static void test_command_does_studies(void **state) {
    (void)state;
    struct bytes study = study_of("\"vary\":{\"start\":{\"grid\":6},\"angle_deg\":[0,45]}");
    struct outcome all =
        run("--format csv --fields variants.angle_deg,variants.failure", study.data);
    assert_int_equal(all.status, 0);
    assert_string_equal(all.out.data,
                        "angle_deg,failure\n0,none\n45,none\n0,none\n45,none\n0,none\n"
                        "45,none\n0,none\n45,none\n0,none\n45,none\n0,none\n45,none\n");
    assert_non_null(strstr(all.err.data, "12 variants in "));
    assert_non_null(strstr(all.err.data, " variant "));
    struct outcome best = run("--variant best", study.data);
    assert_int_equal(best.status, 0);
    struct outcome drape = run("--fields nodes.i", best.out.data);
    assert_int_equal(drape.status, 0);
    assert_non_null(strstr(drape.out.data, "\"max_shear_deg\":"));
    outcome_free(&all);
    outcome_free(&best);
    outcome_free(&drape);
    bytes_free(&study);
}

static void test_command_refuses_what_studies_have_not(void **state) {
    (void)state;
    struct bytes study = study_of("\"vary\":{\"angle_deg\":[0,45]}");
    struct bytes many = study_of("\"vary\":{\"start\":{\"grid\":10000000}}");
    refuse("--format vtp", study.data, 1, "not-acceptable", "a study has no vtp");
    refuse("--variant 2", study.data, 1, "not-found", "2 variants");
    refuse("--variant last", study.data, 1, "not-found", "\"best\"");
    refuse("--variant 0", request_text("saddle"), 1, "not-acceptable", "for studies");
    refuse("--max-variants 1", study.data, 1, "/vary", "1 are allowed");
    refuse("", many.data, 1, "/vary", "1e+07 variants");
    bytes_free(&study);
    bytes_free(&many);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_command_writes_the_result_document),
        cmocka_unit_test(test_command_reads_a_file_or_a_dash),
        cmocka_unit_test(test_command_takes_the_encoders_options),
        cmocka_unit_test(test_command_holds_out_the_rows_of_a_table),
        cmocka_unit_test(test_command_writes_a_report),
        cmocka_unit_test(test_command_says_what_it_is),
        cmocka_unit_test(test_command_refuses_a_wrong_command_line),
        cmocka_unit_test(test_command_explains_problems),
        cmocka_unit_test(test_command_writes_a_whole_file),
        cmocka_unit_test(test_command_leaves_no_partial_file),
        cmocka_unit_test(test_command_keeps_what_is_no_regular_file),
        cmocka_unit_test(test_command_maps_onto_a_mesh),
        cmocka_unit_test(test_command_warns_of_a_mesh_far_away),
        cmocka_unit_test(test_command_explains_what_is_wrong_with_a_map),
        cmocka_unit_test(test_command_does_studies),
        cmocka_unit_test(test_command_refuses_what_studies_have_not),
    };
    return cmocka_run_group_tests_name("command", tests, find_program, remove_folder);
}
