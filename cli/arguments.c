/* SPDX-License-Identifier: MIT */
#include "arguments.h"

#include "api/request/material.h"
#include "files.h"
#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The formats stand between the two; the registry has them. */
static const char help_head[] =
    "Usage: drape [OPTION]... [REQUEST.json|-]\n"
    "Drapes a fabric over a surface. Reads a drape request, by default from standard\n"
    "input, and writes the result, or the fields of the result on a mesh. The surface\n"
    "may be a file, {\"surface\": {\"file\": \"PART.step\"}}, relative to the request's own\n"
    "folder: STEP and IGES (these need drape-import), STL, OBJ or Nastran, whose unit\n"
    "may be given as \"unit\". Select faces as for a stored surface.\n"
    "\n"
    "A laminate has plies, and each is draped. Without --map the outcome of every ply\n"
    "is written, with --map the fields of the whole stack. The formats svg, dxf, astm\n"
    "and hpgl give the flat patterns of all layers on a roll, html gives the ply book.\n"
    "\n"
    "A study has a drape and what to vary. All variants are written (json, csv, npz),\n"
    "and the best are shown as a table: on standard output, or on standard error when\n"
    "the document goes to standard output.\n"
    "\n"
    "  --format FORMAT    default: json; the formats of\n";
static const char help_tail[] =
    "  --map MESH         write the fields on this mesh: Nastran bulk data, decks of\n"
    "                     Abaqus (.inp) and LS-DYNA (.k), Gmsh (.msh), UNV, VTU, STL,\n"
    "                     OBJ, or points or elements as JSON, by the end of the name\n"
    "  --inlet LIST       with --map: elements of the inlet: 17,18,pid:3,set:NAME, by the\n"
    "                     file's ids, properties and sets, or by place:\n"
    "                     sphere:x:y:z:radius, line:x:y:z:x:y:z:distance\n"
    "  --outlet LIST      elements of the outlet, likewise\n"
    "  --reference X,Y,Z  with --map: angles of plies run from this direction, projected\n"
    "                     on each element; default: from its first edge\n"
    "  --edge-channel W,K with --map: elements within W of the rim of the cloth have the\n"
    "                     permeability K, in m^2 (race-tracking)\n"
    "  --cavity-height H  with --map: the height of the cavity, by property or set\n"
    "                     as pid:3:0.002,set:NAME:0.003\n"
    "  --punch LIST       with --map: pid:7,set:NAME, elements that are the other side of\n"
    "                     the cavity; the rest of the mesh lies on the tool\n"
    "  --within D         nastran, abaqus: elements share a stack that is at most D\n"
    "                     degrees and D % of thickness from their own; default: 2; 0:\n"
    "                     no rounding\n"
    "  --plies-as HOW     decks: woven plies as yarns (a layer along warp and one along\n"
    "                     weft), bisector (one layer between both, with the constants\n"
    "                     of fabric.lamina) or warp (one along warp); default: warp\n"
    "  --lcmsim-version N 2 or 3; default: 3\n"
    "  --at-most-fiber-volume-fraction F\n"
    "                     lcmsim: give denser elements this value; without it, elements\n"
    "                     that are too dense to be filled are left out\n"
    "  -o, --output FILE  where to write; default: standard output. The file appears\n"
    "                     when it is complete, or not at all\n"
    "  --fields LIST      only these columns: nodes.x,cells.shear_deg; of a map: k1,k2\n"
    "  --precision P      round numbers to P significant digits, 1..17\n"
    "  --report           the same as --format html\n"
    "  --bundle           the same as --format bundle\n"
    "  --partial          dxf, astm, hpgl: cut what is draped though some of the part stays\n"
    "                     bare\n"
    "  --allowance L      of a drape's pattern: a second line L outside the cut, in the\n"
    "                     length unit\n"
    "  --width W          of a laminate: the width of its rolls, in the length unit;\n"
    "                     default: that of the widest pattern\n"
    "  --gap G            of a laminate: between patterns on a roll\n"
    "  --turn D           of a laminate: 180 (default): patterns may lie turned by half a\n"
    "                     turn; 0: they may not\n"
    "  --roll N           of a laminate of several cloths: roll N alone\n"
    "  --tolerance L      laser, laser-csv, virtek: how far lines may be from curves, in\n"
    "                     the length unit; default: 0.1 mm\n"
    "  --part NAME        svg, dxf, html: for the title\n"
    "  --ply NAME         svg, dxf, html: for the title\n"
    "  --table TABLE      for csv: nodes (default) or cells; of a map cells or plies\n"
    "  --hold-one-out TABLE\n"
    "                     do not drape; tell how well a table of permeabilities, alone\n"
    "                     or in a request, predicts each row and column from the others\n"
    "  --max-nodes N      refuse larger nets; default 4000000\n"
    "  --max-variants N   refuse larger studies; default 1000000\n"
    "  --variant K        of a study: write the drape request of variant K instead, or\n"
    "                     with \"best\" that of the best by the first objective\n"
    "  --threads N        threads to solve with; default 1\n"
    "  --material FILE    a fabric of your own, for the request to name like one of the\n"
    "                     library; may be given several times\n"
    "  --materials        list the fabrics of the library\n"
    "  -h, --help         this text\n"
    "  --version          the version\n"
    "\n"
    "Exit status: 0 on success; 1 when the drape failed, with the reason on standard\n"
    "error; 2 when the command line is wrong.\n";

const char *const arguments_mesh[MESH_OPTIONS] = {"inlet",     "outlet",        "edge-channel",
                                                  "reference", "cavity-height", "punch"};

/* A title and the formats of a use, below each other as the help's other lines are. */
static void print_formats(const char *title, enum format_use use) {
    enum { WIDTH = 79, INDENT = 21 };
    const struct format *format;
    int column = printf("%*s%s", INDENT, "", title);
    for (size_t k = 0; (format = format_at(use, k)); k++) {
        if (column + (int)strlen(format->name) + 2 > WIDTH)
            column = printf("\n%*s", INDENT - 1, "") - 1;
        column += printf(" %s%s", format->name, format_at(use, k + 1) ? "," : "\n");
    }
}

/* A whole number of at least 1 that fits in `most`. */
static bool parse_count(const char *text, long most, size_t *count) {
    char *end;
    errno = 0;
    long value = strtol(text, &end, 10);
    bool ok = errno == 0 && end != text && *end == '\0' && value >= 1 && value <= most;
    *count = ok ? (size_t)value : *count;
    return ok;
}

const char *arguments_parameter(const char *flag) {
    static char name[64];
    size_t length = strlen(flag);
    for (size_t k = 0; k <= length && k < sizeof name; k++)
        name[k] = flag[k] == '-' ? '_' : flag[k];
    return name;
}

/* One option with its value; false when the value is wrong. */
static bool take_argument(struct arguments *arguments, const char *name, const char *value) {
    struct api_limits *limits = &arguments->limits;
    struct api_problem problem = {0};
    /* Those whose text is kept as it is. */
    const struct {
        const char *name, **text;
    } texts[] = {{"format", &arguments->format_name},
                 {"map", &arguments->map},
                 {"variant", &arguments->variant},
                 {"output", &arguments->output},
                 {"hold-one-out", &arguments->table}};
    const char **text = NULL;
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++)
        text = strcmp(name, texts[k].name) == 0 ? texts[k].text : text;
    for (size_t k = 0; k < MESH_OPTIONS; k++)
        text = strcmp(name, arguments_mesh[k]) == 0 ? &arguments->mesh[k] : text;
    if (text) {
        *text = value;
        return true;
    }
    if (strcmp(name, "partial") == 0) {
        arguments->options.partial = true;
        return true;
    }
    if (strcmp(name, "report") == 0 || strcmp(name, "bundle") == 0) {
        arguments->format_name = *name == 'r' ? "html" : "bundle";
        return true;
    }
    if (strcmp(name, "material") == 0) {
        struct material_files *files = &arguments->materials;
        if (files->count < MATERIAL_FILES_MAX)
            files->path[files->count] = value;
        return files->count++ < MATERIAL_FILES_MAX;
    }
    if (strcmp(name, "max-nodes") == 0)
        return parse_count(value, 1000000000, &limits->max_nodes);
    if (strcmp(name, "max-variants") == 0)
        return parse_count(value, 1000000000, &limits->max_variants);
    if (strcmp(name, "threads") == 0) {
        size_t threads = 0;
        bool ok = parse_count(value, 1024, &threads);
        limits->threads = (int)threads;
        return ok;
    }
    if (laminate_roll_option(&arguments->roll, name, value, &problem) || problem.id != API_OK)
        return problem.id == API_OK;
    return format_option(&arguments->options, arguments_parameter(name), value, &problem);
}

static const struct option option_table[] = {
    {"format", required_argument, NULL, 0},
    {"output", required_argument, NULL, 'o'},
    {"map", required_argument, NULL, 0},
    {"hold-one-out", required_argument, NULL, 0},
    {"inlet", required_argument, NULL, 0},
    {"outlet", required_argument, NULL, 0},
    {"reference", required_argument, NULL, 0},
    {"within", required_argument, NULL, 0},
    {"plies-as", required_argument, NULL, 0},
    {"edge-channel", required_argument, NULL, 0},
    {"cavity-height", required_argument, NULL, 0},
    {"punch", required_argument, NULL, 0},
    {"lcmsim-version", required_argument, NULL, 0},
    {"at-most-fiber-volume-fraction", required_argument, NULL, 0},
    {"fields", required_argument, NULL, 0},
    {"allowance", required_argument, NULL, 0},
    {"partial", no_argument, NULL, 0},
    {"report", no_argument, NULL, 0},
    {"bundle", no_argument, NULL, 0},
    {"width", required_argument, NULL, 0},
    {"gap", required_argument, NULL, 0},
    {"turn", required_argument, NULL, 0},
    {"roll", required_argument, NULL, 0},
    {"tolerance", required_argument, NULL, 0},
    {"part", required_argument, NULL, 0},
    {"ply", required_argument, NULL, 0},
    {"precision", required_argument, NULL, 0},
    {"table", required_argument, NULL, 0},
    {"threads", required_argument, NULL, 0},
    {"max-nodes", required_argument, NULL, 0},
    {"max-variants", required_argument, NULL, 0},
    {"variant", required_argument, NULL, 0},
    {"material", required_argument, NULL, 0},
    {"materials", no_argument, NULL, 'm'},
    {"help", no_argument, NULL, 'h'},
    {"version", no_argument, NULL, 'v'},
    {0},
};

int arguments_parse(struct arguments *arguments, int argc, char **argv) {
    static const enum format_use uses[] = {FORMAT_RESULT, FORMAT_PATTERN, FORMAT_REPORT,
                                           FORMAT_LASER, FORMAT_BUNDLE};
    int option, index = 0;
    while ((option = getopt_long(argc, argv, "ho:", option_table, &index)) != -1) {
        const char *name = option == 'o' ? "output" : option_table[index].name;
        if (option == 'h') {
            fputs(help_head, stdout);
            print_formats("a result:", FORMAT_RESULT);
            print_formats("its flat cut pattern:", FORMAT_PATTERN);
            print_formats("a report to print:", FORMAT_REPORT);
            print_formats("of a laminate, for laser projectors:", FORMAT_LASER);
            print_formats("of a laminate, all of these in a zip:", FORMAT_BUNDLE);
            print_formats("with --map, on a mesh:", FORMAT_MAP);
            fputs(help_tail, stdout);
        }
        const struct api_material *material; /* each with the line that says what it is */
        for (size_t k = 0; option == 'm' && (material = api_material_at(k)); k++)
            printf("%-28s%s\n", material->name, material->about);
        if (option == 'h' || option == 'm')
            return fflush(stdout) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
        if (option == 'v')
            return puts("drape " DRAPE_VERSION) < 0 ? EXIT_FAILURE : EXIT_SUCCESS;
        if (option == '?')
            return EXIT_USAGE;
        if (!take_argument(arguments, name, optarg)) {
            fprintf(stderr, "drape: --%s does not take \"%s\"\n", name, optarg);
            return EXIT_USAGE;
        }
    }
    if (argc - optind > 1) {
        files_complain(argv[optind + 1], "one request at a time");
        return EXIT_USAGE;
    }
    if (optind < argc && strcmp(argv[optind], "-") != 0)
        arguments->input = argv[optind];
    if (arguments->output && strcmp(arguments->output, "-") == 0)
        arguments->output = NULL;
    for (int k = 0; k < MESH_OPTIONS; k++) {
        if (arguments->mesh[k] && !arguments->map) {
            fprintf(stderr, "drape: --%s: needs --map\n", arguments_mesh[k]);
            return EXIT_USAGE;
        }
    }
    const char *name = arguments->format_name ? arguments->format_name : "json";
    if (arguments->map)
        arguments->format = format_named(FORMAT_MAP, name);
    for (size_t k = 0; !arguments->map && !arguments->format && k < sizeof uses / sizeof *uses; k++)
        arguments->format = format_named(uses[k], name);
    if (arguments->format)
        return -1;
    fprintf(stderr, "drape: --format does not take \"%s\"%s\n", name,
            arguments->map ? " with --map" : "");
    return EXIT_USAGE;
}
