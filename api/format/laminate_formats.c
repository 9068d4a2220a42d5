/* SPDX-License-Identifier: MIT */
/* What laminates write themselves (`api/laminate/patterns.h`): no encoder does. */
#include "format.h"

const struct format format_account = {
    .name = "json",
    .media_type = "application/json",
    .about = "what became of each ply: coverage, shear, seams, courses",
    .exact = "every bit",
    .uses = FORMAT_BOOK};

const struct format format_laser = {
    .name = "laser",
    .media_type = "application/x-laser+json",
    .about = "lines for laser projectors: of each layer its edge, as points with normals",
    .exact = "every bit",
    .uses = FORMAT_LASER};

const struct format format_laser_csv = {.name = "laser-csv",
                                        .media_type = "text/x-laser-csv",
                                        .about = "the same as a table, a row for each point",
                                        .exact = "every bit",
                                        .uses = FORMAT_LASER};

const struct format format_virtek = {
    .name = "virtek",
    .media_type = "text/x-virtek-ply",
    .about = "the same as a PLY file for projectors of Virtek, in millimetres",
    .exact = "0.0001 mm",
    .uses = FORMAT_LASER};

const struct format format_bundle = {
    .name = "bundle",
    .media_type = "application/zip",
    .about = "all that leaves the house: request, ply book, patterns, laser lines, results, decks",
    .exact = "as each file",
    .uses = FORMAT_BUNDLE};
