/* SPDX-License-Identifier: MIT */
/* The version of everything: what daemon, commands, client and packages say of themselves
 * (deploy/version.py has the files that repeat it). Results are kept by it: it is raised at a
 * release, and between releases whenever the same request may give other numbers. */
#ifndef DRAPE_VERSION
#define DRAPE_VERSION "1.0.0-rc1"
#endif
