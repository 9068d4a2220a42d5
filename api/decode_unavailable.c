/* SPDX-License-Identifier: MIT */
#include "decode_parts.h"

/* What is understood, but comes with a later version: its line goes when a feature lands. */
void decode_refuse_unavailable(const struct tree_place *root, const struct tree_place *surface,
                               const struct api_request *request) {
    (void)surface;
    const struct {
        const struct tree_place *owner;
        const char *key, *member; /* NULL: the owner itself, the key's value itself */
        bool wanted;
        const char *name;
    } features[] = {
        {root, "permeability", NULL, request->permeability.model != API_PERMEABILITY_NONE,
         "permeability"},
    };
    for (size_t i = 0; i < sizeof features / sizeof *features; i++) {
        if (!features[i].wanted)
            continue;
        const struct tree_place *place = features[i].owner;
        struct tree_place value, member;
        if (features[i].key) {
            value = tree_member(place, features[i].key);
            place = &value;
        }
        if (features[i].member) {
            member = tree_member(place, features[i].member);
            place = &member;
        }
        tree_fault(place, "%s is not available in this version", features[i].name);
    }
}
