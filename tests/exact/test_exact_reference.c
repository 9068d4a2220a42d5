#include "check.h"
#include "march.h"
#include "scenes.h"
#include <stdio.h>
int main(int c, char **v) {
    int pad = c > 1 ? 4 : 0;
    (void)v;
    static struct scene scene;
    for (int id = 0; id < SCENE_COUNT; id++) {
        scene_make(&scene, id);
        for (int m = 0; m < 3; m++) {
            static const enum drape_method methods[] = {DRAPE_BASIC, DRAPE_GIB, DRAPE_GIB4};
            double last = 0, lastg = 0;
            printf("%-26s m%d", scene.name, m);
            for (int n = 16; n <= 64; n *= 2) {
                struct plain_setup setup = {
                    &scene.shape,      {scene.start_uv[0], scene.start_uv[1]},
                    scene.start.warp,  scene.start.weft,
                    methods[m],        {scene.length[0] / n, scene.length[1] / n},
                    {n + pad, n + pad}};
                struct drape_nodes *nodes = plain_make(&setup);
                struct net_error e =
                    measure_error(nodes, scene.reference, setup.spacing, (int[2]){n, n});
                e.position /= scene.side;
                printf("  %9.2e %9.2e deg (%4.2f %4.2f)", e.position, e.shear_deg,
                       order_of(last, e.position), order_of(lastg, e.shear_deg));
                last = e.position;
                lastg = e.shear_deg;
                plain_free(nodes);
            }
            printf("\n");
        }
        scene_free(&scene);
    }
}
