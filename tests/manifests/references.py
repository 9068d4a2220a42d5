#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What no schema knows of deploy/kubernetes and deploy/compose.yaml: that names lead somewhere, and
that the daemon takes the settings. Says what is wrong, and exits with 1 then.
Usage: references.py DRAPED
"""
import glob
import os
import re
import subprocess
import sys

import yaml

faults = []
SECRETS = ("DRAPED_STORE", "DRAPED_TOKENS")  # their values are there only where draped runs


def expect(condition, text):
    if not condition:
        faults.append(text)


def load(path):
    with open(path, encoding="utf-8") as file:
        return [document for document in yaml.safe_load_all(file) if document]


def expect_settings(draped, where, settings):
    """Names of variables are those of --help, and their values make sense to the daemon."""
    known = subprocess.run([draped, "--help"], capture_output=True, text=True, check=True).stdout
    for name in settings:
        expect(f"({name})" in known, f"{where}: draped knows no {name}")
    values = {name: value for name, value in settings.items() if value and name not in SECRETS}
    values.setdefault("DRAPED_ALLOW_ANONYMOUS", "1")
    answer = subprocess.run([draped, "--check-config"], capture_output=True, text=True,
                            env={"DRAPED_LISTEN": "0.0.0.0:8080", **values}, check=False)
    expect(answer.returncode == 0, f"{where}: {answer.stderr.strip()}")


def matches(selector, labels):
    return all(labels.get(key) == value for key, value in selector.get("matchLabels", {}).items())


def named(objects, kind):
    return {each["metadata"]["name"]: each for each in objects if each["kind"] == kind}


def check_deployment(draped, name, deployment, user):
    spec = deployment["spec"]
    pod = spec["template"]["spec"]
    expect(matches(spec["selector"], spec["template"]["metadata"]["labels"]), f"{name}: selector")
    expect(f"{pod['securityContext']['runAsUser']}" == user, f"{name}: not the image's user")
    volumes = {volume["name"]: volume for volume in pod.get("volumes", [])}
    used = set()
    for container in pod["containers"]:
        ports = {port["name"] for port in container["ports"]}
        for key in ("startupProbe", "livenessProbe", "readinessProbe"):
            expect(key not in container or container[key]["httpGet"]["port"] in ports, f"{name}: {key}")
        used |= {mount["name"] for mount in container.get("volumeMounts", [])}
        expect_settings(draped, name, {each["name"]: each.get("value") for each in container["env"]})
        for each in container["env"]:
            secret = each.get("valueFrom", {}).get("secretKeyRef")
            expect(not secret or secret in ({"name": "draped", "key": "store"},
                                            {"name": "draped", "key": "tokens"}), f"{name}: secret")
    expect(used == set(volumes), f"{name}: volumes {sorted(used ^ set(volumes))}")


def check_kubernetes(draped, folder, user, version):
    kustomization = load(f"{folder}/kustomization.yaml")[0]
    there = {os.path.basename(path) for path in glob.glob(f"{folder}/*.yaml")}
    expect(set(kustomization["resources"]) == there - {"kustomization.yaml"}, "kustomization: resources")
    images = {image["name"]: image["newTag"] for image in kustomization["images"]}
    expect(images == {"draped": version}, f"kustomization: images {images}, not version {version}")
    objects = [each for name in kustomization["resources"] for each in load(f"{folder}/{name}")]
    deployments, services = named(objects, "Deployment"), named(objects, "Service")
    expect(kustomization["namespace"] in named(objects, "Namespace"), "kustomization: namespace")
    labels = {name: each["spec"]["template"]["metadata"]["labels"] for name, each in deployments.items()}

    def selected(selector):
        return [name for name in deployments if matches(selector, labels[name])]

    for name, deployment in deployments.items():
        check_deployment(draped, name, deployment, user)
        images_used = {each["image"] for each in deployment["spec"]["template"]["spec"]["containers"]}
        expect(images_used <= set(images), f"{name}: image {images_used}")
    for name, service in services.items():
        chosen = selected({"matchLabels": service["spec"]["selector"]})
        expect(len(chosen) == 1, f"service {name}: selects {chosen}")
        ports = {port["name"] for each in chosen
                 for port in deployments[each]["spec"]["template"]["spec"]["containers"][0]["ports"]}
        expect(all(port["targetPort"] in ports for port in service["spec"]["ports"]), f"service {name}: port")
    for name, budget in named(objects, "PodDisruptionBudget").items():
        expect(selected(budget["spec"]["selector"]) == [name], f"budget {name}")
    for name, policy in named(objects, "NetworkPolicy").items():
        expect(selected(policy["spec"]["podSelector"]), f"policy {name}: selects nothing")
    for name, scaler in named(objects, "ScaledObject").items():
        expect(scaler["spec"]["scaleTargetRef"]["name"] in deployments, f"scaler {name}")
        for trigger in scaler["spec"]["triggers"]:
            host = re.match(r"http://([^./]+)\.([^./]+)\.svc/metrics$", trigger["metadata"]["url"])
            expect(host and host[1] in services and host[2] == kustomization["namespace"], f"scaler {name}: url")
    for name, ingress in named(objects, "Ingress").items():
        for path in [path for rule in ingress["spec"]["rules"] for path in rule["http"]["paths"]]:
            backend = path["backend"]["service"]
            service = services.get(backend["name"], {"spec": {"ports": []}})
            expect(backend["port"]["name"] in {port["name"] for port in service["spec"]["ports"]},
                   f"ingress {name}: {path['path']}")


def octets(text):
    """Bytes of a size as Kubernetes, nginx or the daemon writes it."""
    number, unit = re.fullmatch(r"(\d+)([KMGkmg]?)i?", str(text)).groups()
    return int(number) * 1024 ** " KMG".index(unit.upper() or " ")


def settings_of(draped, values):
    """What the daemon makes of these variables, by name; numbers as integers."""
    answer = subprocess.run([draped, "--check-config"], capture_output=True, text=True,
                            env={"DRAPED_ALLOW_ANONYMOUS": "1", **values}, check=False).stdout
    pairs = dict(line.split(" = ", 1) for line in answer.splitlines())
    return {name: int(value) if value.isdigit() else value for name, value in pairs.items()}


def covers(rule, path):
    if rule["pathType"] == "Exact":
        return rule["path"] == path
    return path == rule["path"].rstrip("/") or path.startswith(rule["path"].rstrip("/") + "/")


def check_ingress(limits, folder):
    """All that callers may use goes through, what is for the inside does not; bodies as the daemon."""
    with open("api/openapi.yaml", encoding="utf-8") as file:
        routes = {re.sub(r"\{[^}]*\}", "x", path) for path in yaml.safe_load(file)["paths"]}
    ingress = named(load(f"{folder}/ingress.yaml"), "Ingress")["draped"]
    rules = [path for rule in ingress["spec"]["rules"] for path in rule["http"]["paths"]]
    for route in routes:
        inside = route in ("/metrics", "/healthz", "/readyz")
        expect(any(covers(rule, route) for rule in rules) != inside, f"ingress: {route}")
    notes = {key.split("/")[1]: value for key, value in ingress["metadata"]["annotations"].items()}
    expect(octets(notes["proxy-body-size"]) == limits["max-mesh"], "ingress: bodies are not --max-mesh")


def check_memory(draped, folder):
    """No pod may be killed for what its settings allow it to hold."""
    objects = [each for name in ("api", "worker") for each in load(f"{folder}/{name}.yaml")]
    for name, deployment in named(objects, "Deployment").items():
        container = deployment["spec"]["template"]["spec"]["containers"][0]
        settings = settings_of(draped, {each["name"]: each["value"] for each in container["env"]
                                        if "value" in each and each["name"] not in SECRETS})
        worker = settings["role"] == "worker"
        most = ((settings["workers"] + 1) * settings["job-memory"] if worker
                else settings["max-bodies"] + settings["check-memory"]) + 256 * 1024 ** 2
        limit = octets(container["resources"]["limits"]["memory"])
        expect(limit >= most, f"{name}: {limit} bytes of memory, and it may hold {most}")
        expect("readinessProbe" in container, f"{name}: no readiness probe")
        expect(container["readinessProbe"]["httpGet"]["path"] == "/readyz", f"{name}: readiness")


def check_scaler(folder):
    """/metrics takes a token, so that who looks at it has one."""
    objects = load(f"{folder}/scaler.yaml")
    there = named(objects, "TriggerAuthentication")
    for name, scaler in named(objects, "ScaledObject").items():
        for trigger in scaler["spec"]["triggers"]:
            reference = trigger.get("authenticationRef", {}).get("name")
            expect(reference in there and trigger["metadata"]["authMode"] == "bearer", f"scaler {name}: no token")
    with open("deploy/prometheus/kubernetes.yml", encoding="utf-8") as file:
        scrape = yaml.safe_load(file)["scrape_configs"][0]
    expect("credentials_file" in scrape.get("authorization", {}), "prometheus: no token")


def check_proxies(limits):
    """Their caps on bodies are the daemon's."""
    with open("deploy/nginx.conf", encoding="utf-8") as file:
        sizes = [octets(size) for size in re.findall(r"client_max_body_size (\w+);", file.read())]
    expect(set(sizes) == {limits["max-body"], limits["max-mesh"]}, f"nginx: bodies {sizes}")
    with open("deploy/Caddyfile", encoding="utf-8") as file:
        sizes = [int(size) for size in re.findall(r"max_size (\d+)", file.read())]
    expect(set(sizes) == {limits["max-mesh"], limits["max-body"]}, f"Caddy: bodies {sizes}")


def check_compose(draped, path):
    compose = load(path)[0]
    services = compose["services"]
    for name, service in services.items():
        for key in ("secrets", "networks"):
            for each in service.get(key, []):
                expect(each == "default" or each in compose[key], f"compose {name}: {key} {each}")
        for volume in service.get("volumes", []):
            expect(volume.split(":")[0] in compose["volumes"], f"compose {name}: volume {volume}")
        for other in service.get("depends_on", {}):
            expect(other in services and services[other]["profiles"] == service["profiles"],
                   f"compose {name}: depends on {other}")
            expect("healthcheck" in services[other], f"compose {name}: {other} has no health check")
        if service["image"] == "draped":
            expect_settings(draped, f"compose {name}", service["environment"])
            expect(os.path.isfile(os.path.join("deploy", service["build"]["context"],
                                               service["build"]["dockerfile"])), f"compose {name}: file")
    expect({tuple(each["profiles"]) for each in services.values()} == {("sqlite",), ("postgres",)},
           "compose: profiles")


def main():
    draped = os.path.abspath(sys.argv[1])
    version = subprocess.run([draped, "--version"], capture_output=True, text=True, check=True).stdout.split()[1]
    with open("deploy/container/Containerfile", encoding="utf-8") as file:
        user = re.search(r"^USER (\d+)", file.read(), re.MULTILINE)[1]
    check_kubernetes(draped, "deploy/kubernetes", user, version)
    check_compose(draped, "deploy/compose.yaml")
    limits = settings_of(draped, {})
    check_ingress(limits, "deploy/kubernetes")
    check_memory(draped, "deploy/kubernetes")
    check_scaler("deploy/kubernetes")
    check_proxies(limits)
    print("\n".join(faults))
    sys.exit(1 if faults else 0)


main()
