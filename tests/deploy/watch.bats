# SPDX-License-Identifier: MIT
# Alerts, dashboard and runbook: sound by Prometheus's own tool, true of what a daemon tells, and in
# step with each other.
load helper

setup_file() {
    start_shared_daemon
    # A drape and a call for each way of ending that counters are made by.
    post /v1/drapes $EXAMPLES/saddle.json -H 'Prefer: wait=30'
    expect 200
    call GET /metrics
    expect 200
    call GET /metrics
    cp "$body" "$BATS_FILE_TMPDIR/metrics"
}
teardown_file() { stop_daemon; }

# setup_file has no folder of a test's own.
BATS_TEST_TMPDIR=${BATS_TEST_TMPDIR:-$BATS_FILE_TMPDIR}

@test "deploy: the metrics are as Prometheus likes them" {
    build/tools/promtool check metrics <"$BATS_FILE_TMPDIR/metrics"
}

@test "deploy: promtool takes the rules, and each alert comes where it should" {
    build/tools/promtool check config deploy/prometheus/prometheus.yml
    build/tools/promtool test rules deploy/prometheus/draped.tests.yml
    # No alert is without a test that it comes, nor without one that it stays away.
    sed -n 's/^ *- alert: //p' deploy/prometheus/draped.rules.yml | while read -r alert; do
        grep -A1 "alertname: $alert\$" deploy/prometheus/draped.tests.yml | grep -q exp_alerts
        grep -q "alertname: $alert}" deploy/prometheus/draped.tests.yml
    done
}

# Debian's Prometheus is built without discovery in Kubernetes: that part is compared with what is there
# to be found, promtool takes the rest.
@test "deploy: promtool takes the configuration for Kubernetes, which finds our pods" {
    cp deploy/prometheus/draped.rules.yml "$BATS_TEST_TMPDIR"
    touch "$BATS_TEST_TMPDIR/token"
    python3 - "$BATS_TEST_TMPDIR" <<'END'
import glob, sys, yaml
with open("deploy/prometheus/kubernetes.yml") as file:
    config = yaml.safe_load(file)
with open("deploy/kubernetes/kustomization.yaml") as file:
    namespace = yaml.safe_load(file)["namespace"]
scrape = config["scrape_configs"][0]
discovery = scrape.pop("kubernetes_sd_configs")
assert discovery == [{"role": "pod", "namespaces": {"names": [namespace]}}], discovery
pods = [document["spec"]["template"] for name in ("api", "worker")
        for document in yaml.safe_load_all(open(f"deploy/kubernetes/{name}.yaml"))
        if document["kind"] == "Deployment"]
found = lambda pod, port: {
    **{"__meta_kubernetes_pod_annotation_" + "".join(c if c.isalnum() else "_" for c in name): value
       for name, value in pod["metadata"]["annotations"].items()},
    "__meta_kubernetes_pod_container_port_name": port["name"],
    "__meta_kubernetes_pod_name": "pod", "__meta_kubernetes_namespace": namespace}
for pod in pods:
    ports = pod["spec"]["containers"][0]["ports"]
    kept = [port for port in ports if all(
        found(pod, port)[rule["source_labels"][0]] == rule["regex"]
        for rule in scrape["relabel_configs"] if rule.get("action") == "keep")]
    assert [port["containerPort"] for port in kept] == [8080], pod["metadata"]
    for rule in scrape["relabel_configs"]:
        assert set(rule["source_labels"]) <= found(pod, ports[0]).keys(), rule
scrape["static_configs"] = [{"targets": ["pod:8080"]}]
scrape["authorization"]["credentials_file"] = f"{sys.argv[1]}/token"
with open(f"{sys.argv[1]}/prometheus.yml", "w") as file:
    yaml.safe_dump(config, file)
END
    build/tools/promtool check config "$BATS_TEST_TMPDIR/prometheus.yml"
}

# The expressions of rules and panels, one a line.
expressions() {
    python3 - <<'END'
import json, yaml
for group in yaml.safe_load(open("deploy/prometheus/draped.rules.yml"))["groups"]:
    for rule in group["rules"]:
        print(" ".join(rule["expr"].split()))
for panel in json.load(open("deploy/grafana/draped.json"))["panels"]:
    for target in panel["targets"]:
        print(target["expr"].replace("$__rate_interval", "5m").replace("$job", "draped")
              .replace("$database", ".*"))
END
}

@test "deploy: every panel's expression is one" {
    expressions | jq -R '{record: "check:\(input_line_number)", expr: .}' |
        jq -s '{groups: [{name: "panels", rules: .}]}' >"$BATS_TEST_TMPDIR/panels.yml"
    [ "$(jq '.groups[0].rules | length' "$BATS_TEST_TMPDIR/panels.yml")" -gt 25 ]
    build/tools/promtool check rules "$BATS_TEST_TMPDIR/panels.yml"
}

@test "deploy: what rules and panels ask for is what a daemon tells" {
    expressions >"$BATS_TEST_TMPDIR/expressions"
    grep -oE 'draped_[a-z_]+' "$BATS_TEST_TMPDIR/expressions" | sort -u >"$BATS_TEST_TMPDIR/wanted"
    grep -oE '^draped_[a-z_]+' "$BATS_FILE_TMPDIR/metrics" | sort -u >"$BATS_TEST_TMPDIR/told"
    [ "$(wc -l <"$BATS_TEST_TMPDIR/wanted")" -ge 9 ]
    [ -z "$(comm -23 "$BATS_TEST_TMPDIR/wanted" "$BATS_TEST_TMPDIR/told")" ] ||
        { comm -23 "$BATS_TEST_TMPDIR/wanted" "$BATS_TEST_TMPDIR/told"; false; }
    # Labels: the daemon's, and those that Prometheus and its configuration add.
    {
        grep -oE '[a-z_]+="' "$BATS_FILE_TMPDIR/metrics" | tr -d '="'
        printf 'job\ninstance\ndatabase\n'
    } | sort -u >"$BATS_TEST_TMPDIR/labels"
    {
        grep -oE '[a-z_]+=~?"' "$BATS_TEST_TMPDIR/expressions" | tr -d '=~"'
        grep -oE '(by|on) \([^)]*\)' "$BATS_TEST_TMPDIR/expressions" | sed -E 's/(by|on) \(//; s/)//; s/, */\n/g'
    } | sort -u >"$BATS_TEST_TMPDIR/asked"
    [ -z "$(comm -23 "$BATS_TEST_TMPDIR/asked" "$BATS_TEST_TMPDIR/labels")" ] ||
        { comm -23 "$BATS_TEST_TMPDIR/asked" "$BATS_TEST_TMPDIR/labels"; false; }
    # And so are the series of the rules' tests, with the values of their labels.
    grep -oE 'draped_store_drapes_total\{[^}]*\}' deploy/prometheus/draped.tests.yml |
        grep -oE 'outcome="[a-z]+"' | sort -u | while read -r outcome; do
        grep -qF "draped_store_drapes_total{$outcome}" "$BATS_FILE_TMPDIR/metrics"
    done
    grep -qE '^draped_http_requests_total\{method="GET",route="/metrics",status="200"\} ' \
        "$BATS_FILE_TMPDIR/metrics"
}

@test "deploy: the panels lie side by side, and each has a title and a place" {
    jq -e '.panels | length > 10 and ([.[].id] | length == (unique | length)) and
           all((.title | length > 0) and .gridPos.x + .gridPos.w <= 24 and (.targets | length > 0))' \
        deploy/grafana/draped.json
    jq -e '[.panels[] | .gridPos as $g | range($g.x; $g.x + $g.w) as $x |
            range($g.y; $g.y + $g.h) as $y | [$x, $y]] | length == (unique | length)' \
        deploy/grafana/draped.json
}

@test "deploy: the runbook has every alert, and no other" {
    sed -n 's/^ *- alert: //p' deploy/prometheus/draped.rules.yml | sort >"$BATS_TEST_TMPDIR/alerts"
    sed -n 's/^## \(Draped[A-Za-z]*\)$/\1/p' docs/runbook.md | sort >"$BATS_TEST_TMPDIR/entries"
    diff "$BATS_TEST_TMPDIR/alerts" "$BATS_TEST_TMPDIR/entries"
    # The links lead there, and each entry says what it means and what to do.
    sed -n 's/.*runbook: "runbook\.md#\([a-z]*\)"/\1/p' deploy/prometheus/draped.rules.yml | sort |
        diff - <(tr 'A-Z' 'a-z' <"$BATS_TEST_TMPDIR/alerts")
    awk '/^## Draped/ {if (name && (!means || !act)) {print name; bad = 1} name = $2; means = act = 0}
         /^\*\*Means\*\*/ {means = 1} /^\*\*Do\*\*/ {act = 1}
         END {exit bad || !means || !act}' docs/runbook.md
}
