# SPDX-License-Identifier: MIT
# The container file, Compose and Kubernetes are not run here: no image can be pulled. They are held
# to the schemas that others keep, and to what they refer to. So is the bill of materials.
load helper

# documents FILE...: all YAML documents of the files, as a JSON array.
documents() {
    python3 -c 'import json, sys, yaml
print(json.dumps([d for f in sys.argv[1:] for d in yaml.safe_load_all(open(f)) if d]))' "$@"
}

validate() { node tests/manifests/validate.mjs "$1"; }
refuses() { validate "$1" | grep -E 'checked, [1-9][0-9]* faults'; } # and does not just break
kubernetes() { documents $(ls deploy/kubernetes/*.yaml | grep -v kustomization); }

@test "deploy: Kubernetes' and KEDA's schemas take the manifests (validated, not run)" {
    kubernetes | validate kubernetes
    # And they do not take everything: a misspelt key, a wrong type, a kind that there is not.
    kubernetes | sed 's/"readinessProbe"/"readynessProbe"/' | refuses kubernetes
    kubernetes | sed 's/"containerPort": 8080/"containerPort": "web"/' | refuses kubernetes
    kubernetes | sed 's/"PodDisruptionBudget"/"PodBudget"/' | refuses kubernetes
    kubernetes | sed 's/"scaleTargetRef"/"scaleTarget"/' | refuses kubernetes
}

@test "deploy: Compose's schema takes compose.yaml (validated, not run)" {
    documents deploy/compose.yaml | validate compose
    documents deploy/compose.yaml | sed 's/"read_only": true/"readonly": true/g' | refuses compose
}

@test "deploy: the container file is one (parsed, not built)" {
    validate container <deploy/container/Containerfile
    sed 's/^EXPOSE.*/EXPOSE http/' deploy/container/Containerfile | refuses container
    # Two stages, no root, a health check by the daemon itself.
    [ "$(grep -c '^FROM' deploy/container/Containerfile)" = 2 ]
    [ "$(sed -n 's/^USER //p' deploy/container/Containerfile | tail -1)" = 10001:10001 ]
    grep -q '^HEALTHCHECK .* CMD \["draped", "--healthcheck"\]$' deploy/container/Containerfile
    # What it calls is there.
    deploy/setup.sh package
    make -n deb | grep -q deb.sh
}

@test "deploy: names in manifests lead somewhere, and the daemon takes the settings" {
    python3 tests/manifests/references.py "$DRAPED"
}

@test "deploy: the bill of materials is CycloneDX, and lists what the programs load" {
    make -s sbom B="${BUILD:-build}"
    bom=${BUILD:-build}/draped.cdx.json
    validate cyclonedx <"$bom"
    sed 's/"scope": "required"/"scope": "must"/' "$bom" | refuses cyclonedx
    for name in libmicrohttpd12 libjansson4 libgeos-c1v5 libsqlite3-0 libc6; do
        version=$(dpkg-query -W -f '${Version}' "$name")
        jq -e --arg name "$name" --arg version "$version" \
            'any(.components[]; .name == $name and .version == $version and .scope == "required")' "$bom"
    done
    jq -e --arg sum "$(sha256sum <"$DRAPED" | cut -d' ' -f1)" \
        'any(.components[]; .name == "draped" and .hashes[0].content == $sum)' "$bom"
}
