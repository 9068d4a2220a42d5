#!/bin/bash
# SPDX-License-Identifier: MIT
# Six hosts: a PostgreSQL server, two that answer calls, three that work, each in a network namespace
# with an address of its own on a bridge that nothing else is connected to. Drapes are submitted to
# both api hosts; meanwhile one worker host dies, one is cut off from the database for longer than
# its lease, and the database crashes and comes back. Every drape must end, once, with the bits that
# build/drape gives on this machine. So must a study whose tasks are spread over all workers, one of
# which dies with them.
# Where namespaces are not permitted the hosts are addresses 127.0.0.x, and the one that would be
# cut off is stopped instead. Speaks TAP. Usage: tests/hosts/hosts.sh BUILD [DRAPES]
set -u
cd "$(dirname "$0")/../.." || exit 1
. tests/postgres.bash
build=$1 drapes=${2:-200} lease=3
work=$(mktemp -d /tmp/draped-hosts-XXXXXX)
tag=dr$$ tests=0 failed=0
declare -A address=([db]=1 [api1]=11 [api2]=12 [w1]=21 [w2]=22 [w3]=23)
declare -A process=()
chmod 755 "$work"

ok() { # ok COMMAND... -- what: one test
    local command=()
    while [ "$1" != -- ]; do command+=("$1"); shift; done
    tests=$((tests + 1))
    if "${command[@]}"; then
        echo "ok $tests - $2"
    else
        echo "not ok $tests - $2"
        failed=$((failed + 1))
    fi
}
note() { echo "# $*"; }
now_ms() { echo $(($(date +%s%N) / 1000000)); }

# ------------------------------------------------------------------ the network

make_network() {
    ip netns add "$tag-net" 2>"$work/ip" && ip -n "$tag-net" link set lo up &&
        ip -n "$tag-net" link add bridge type bridge && ip -n "$tag-net" link set bridge up &&
        ip -n "$tag-net" addr add 10.77.0.254/24 dev bridge || return 1
    local host
    for host in "${!address[@]}"; do
        ip netns add "$tag-$host" && ip -n "$tag-$host" link set lo up &&
            ip -n "$tag-net" link add "$host" type veth peer name eth0 netns "$tag-$host" &&
            ip -n "$tag-net" link set "$host" master bridge up &&
            ip -n "$tag-$host" addr add "10.77.0.${address[$host]}/24" dev eth0 &&
            ip -n "$tag-$host" link set eth0 up || return 1
    done
}

if make_network 2>>"$work/ip"; then
    network=10.77.0
    note "hosts are network namespaces on $network.0/24"
    on() { echo ip netns exec "$tag-$1"; }
    cut_off() { ip -n "$tag-net" link set "$1" down; }
    join_again() { ip -n "$tag-net" link set "$1" up; }
else
    network=127.0.0
    note "hosts are addresses $network.x: no network namespaces here: $(tail -n 1 "$work/ip")"
    on() { :; }
    cut_off() { kill -STOP "${process[$1]}"; }
    join_again() { kill -CONT "${process[$1]}"; }
fi

clean_up() {
    local host
    for host in "${!process[@]}"; do
        kill -CONT "${process[$host]}" 2>/dev/null
        kill -KILL "${process[$host]}" 2>/dev/null
    done
    [ ${#process[@]} -eq 0 ] || wait "${process[@]}" 2>/dev/null
    postgres_stop
    for host in "${!address[@]}" net; do
        ip netns del "$tag-$host" 2>/dev/null
    done
    rm -rf "$work"
}
trap clean_up EXIT
trap 'exit 1' INT TERM

# ------------------------------------------------------------------ the hosts

start_database() { postgres_start "$work/pg" "$network.1" $(on db); }

# start HOST: an api or a worker with one lane.
start() {
    local role=worker
    case $1 in api*) role=api ;; esac
    : >"$work/$1.out"
    $(on "$1") env DRAPED_STORE="postgresql://draped@$network.1/postgres" \
        setpriv --pdeathsig KILL "$build/draped" --listen "$network.${address[$1]}:8080" \
        --allow-anonymous --role $role --workers 1 --lease $lease --queue-limit 1000000 \
        >"$work/$1.out" 2>>"$work/$1.log" 3>&- &
    process[$1]=$!
    local end=$((SECONDS + 30))
    until grep -q listening "$work/$1.out"; do
        kill -0 "${process[$1]}" 2>/dev/null && [ $SECONDS -lt $end ] ||
            { note "$1 does not start: $(tail -n 1 "$work/$1.log")"; exit 1; }
        sleep 0.05
    done
}

# end HOST SIGNAL
end() {
    kill -"$2" "${process[$1]}"
    wait "${process[$1]}" 2>/dev/null
    unset "process[$1]"
}

sql() { "$PG_BIN/psql" -h "$work/pg" -U draped -d postgres -qtAX -c "$1"; }

# calls API FILE: runs the calls of a curl config; what cannot be answered now is tried again.
calls() {
    $(on net) curl --silent --show-error --fail --retry 100 --retry-all-errors --retry-delay 1 \
        --max-time 60 --parallel --parallel-max 4 --config "$1" 2>>"$work/curl"
}

metric() { # metric HOST NAME
    $(on net) curl -s --max-time 10 "http://$network.${address[$1]}:8080/metrics" |
        awk -v name="$2" '$1 == name {print $2}'
}

# ------------------------------------------------------------------ drapes

# make_requests FIRST COUNT: files of distinct drapes, one in ten of them of half a second.
make_requests() {
    jq -c --argjson first "$1" --argjson count "$2" 'range($first; $first + $count) as $k |
        if $k % 10 == 5 then .fabric.spacing = 0.05 * (1 + $k * 1e-5) | .method = "geodesic"
        else .fabric.spacing = 0.2 * (1 + $k * 1e-5) end' api/examples/saddle.json |
        awk -v folder="$work/requests" -v k="$1" \
            '{file = folder "/" k++; print > file; close(file)}'
}

# submit FIRST COUNT: half to each api host; a call that is tried again names the same drape.
submit() {
    local k api
    for api in 0 1; do
        for ((k = $1 + api; k < $1 + $2; k += 2)); do
            printf 'url = "http://%s.1%d:8080/v1/drapes"\ndata-binary = "@%s/requests/%d"\n' \
                $network $((api + 1)) "$work" $k
            printf 'header = "Content-Type: application/json"\nheader = "Idempotency-Key: %d"\n' $k
            printf 'output = "%s/receipts/%d"\nnext\n' "$work" $k
        done | sed '$d' >"$work/submit$api"
        calls "$work/submit$api" &
        submitters[api]=$!
    done
}

submitted() { wait "${submitters[@]}"; }

ended() { [ "$(sql 'SELECT count(*) FROM draped.jobs WHERE status < 2')" = 0 ]; }
how_many() { sql 'SELECT count(*) FROM draped.jobs WHERE status >= 2'; }

# wait_ended SECONDS
wait_ended() {
    local end=$((SECONDS + $1))
    until ended; do
        [ $SECONDS -lt $end ] || return 1
        sleep 0.1
    done
}

# ------------------------------------------------------------------ what is tested

# All drapes are there before the first worker starts; then only the workers' speed counts.
measure() {
    local first=$1 count=$2 workers=${*:3} host begun
    make_requests "$first" "$count"
    submit "$first" "$count"
    submitted
    begun=$(now_ms)
    for host in $workers; do start "$host"; done
    wait_ended 300 || return 1
    note "$((count * 1000 / ($(now_ms) - begun))) drapes/s with $(($# - 2)) worker(s) of one lane" \
        "on $(nproc) cores that database and api hosts share"
    for host in $workers; do end "$host" TERM; done
}

same_bits() {
    local k id
    mkdir -p "$work/results"
    for ((k = 0; k < total; k++)); do
        id=$(sed 's/.*"id":"\([0-9a-f]*\)".*/\1/' "$work/receipts/$k")
        printf 'url = "http://%s.1%d:8080/v1/drapes/%s/result?format=csv&table=nodes"\n' \
            $network $((k % 2 + 1)) "$id"
        printf 'output = "%s/results/%d"\nnext\n' "$work" $k
    done | sed '$d' >"$work/fetch"
    calls "$work/fetch" || return 1
    for ((k = 0; k < total; k++)); do
        "$build/drape" "$work/requests/$k" --format csv | cmp -s - "$work/results/$k" ||
            { note "drape $k differs"; return 1; }
    done
}

# study SPACING: 600 variants of the saddle, posted to the first api host; sets study.
study() {
    jq -c --argjson spacing "$1" '{drape: (.fabric.spacing = $spacing), vary: {start: {grid: 100},
        angle_deg: [0, 15, 30, 45, 60, 75]}, objectives: ["max_shear_deg", "waste_area"]}' \
        api/examples/saddle.json >"$work/study.json"
    printf 'url = "http://%s.11:8080/v1/studies"\ndata-binary = "@%s/study.json"\n' \
        $network "$work" >"$work/post"
    printf 'header = "Content-Type: application/json"\nheader = "Idempotency-Key: study %s"\n' \
        "$1" >>"$work/post"
    printf 'output = "%s/study.receipt"\n' "$work" >>"$work/post"
    calls "$work/post" && study=$(jq -r .id "$work/study.receipt")
}

tasks_done() { sql 'SELECT count(*) FROM draped.task_numbers'; }

# Of the study; the other api host is asked.
same_numbers() {
    printf 'url = "http://%s.12:8080/v1/studies/%s/result?format=csv"\noutput = "%s/study.csv"\n' \
        $network "$study" "$work" >"$work/fetch"
    calls "$work/fetch" && "$build/drape" "$work/study.json" --format csv | cmp - "$work/study.csv"
}

# A study with one worker and one with all: how much faster that is.
measure_studies() {
    local begun one
    for host in w2 w3; do end $host TERM; done
    begun=$(now_ms)
    study 0.0511 && wait_ended 120 || return 1
    one=$(($(now_ms) - begun))
    for host in w2 w3; do start $host; done
    begun=$(now_ms)
    study 0.0512 && wait_ended 120 || return 1
    note "600 variants: $one ms with one worker host, $(($(now_ms) - begun)) ms with three, on" \
        "$(nproc) cores"
}

is() { [ "$1" = "$2" ] || { note "$1, not $2"; return 1; }; }

mkdir -p "$work/requests" "$work/receipts" "$work/pg"
postgres_make "$work/pg" && start_database || exit 1
for host in api1 api2; do start $host; done
# Every end of a drape is written down, by whomever it comes.
sql 'CREATE TABLE ends (job bigint, status integer);
    CREATE FUNCTION note_end() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN
    INSERT INTO ends VALUES (new.sequence, new.status); RETURN NULL; END $$;
    CREATE TRIGGER ends AFTER UPDATE OF status ON draped.jobs FOR EACH ROW
    WHEN (new.status >= 2) EXECUTE FUNCTION note_end();'

part=$((drapes / 5)) total=0
ok measure 0 $part w1 -- "$part drapes end with one worker host"
ok measure $part $part w1 w2 -- "$part drapes end with two"
ok measure $((2 * part)) $part w1 w2 w3 -- "$part drapes end with three"
total=$((3 * part))

rest=$((drapes - total))
for host in w1 w2 w3; do start $host; done
make_requests $total $rest
submit $total $rest
reach() { # reach PARTS: until so many fifths of the rest have ended
    local end=$((SECONDS + 200))
    until [ "$(how_many)" -ge $((total + rest * $1 / 5)) ]; do
        [ $SECONDS -lt $end ] || return 1
        sleep 0.02
    done
}
ok reach 1 -- 'they begin'
end w2 KILL
note 'worker host w2 is dead'
cut_off w3
note "worker host w3 is cut off from the database, for more than its lease of $lease s"
cut_at=$SECONDS
ok reach 2 -- 'the others go on'
postgres_stop QUIT
note 'the database has crashed'
sleep 1
ok start_database -- 'the database comes back'
ok reach 3 -- 'and so do the others, by themselves'
while [ $((SECONDS - cut_at)) -le $((lease + 2)) ]; do sleep 0.2; done
join_again w3
note 'worker host w3 is back'
ok submitted -- 'every submission is acknowledged'
total=$drapes
ok wait_ended 300 -- "all of $drapes drapes end"
note "what w3 did too late was refused: $(metric w3 'draped_drapes_total{outcome="stopped"}') drape(s)"
note "handed out more than once: $(sql 'SELECT count(*) FROM draped.jobs WHERE attempts > 1')"
ok is "$(sql 'SELECT count(*), count(DISTINCT digest) FROM draped.jobs')" "$drapes|$drapes" \
    -- 'none was lost or doubled'
ok is "$(sql 'SELECT count(*) FROM draped.jobs WHERE status <> 2')" 0 -- 'all have succeeded'
ok is "$(sql 'SELECT count(*), count(DISTINCT job) FROM ends')" "$drapes|$drapes" \
    -- 'each has ended once'
ok is "$(sql 'SELECT count(*) FROM draped.results WHERE state = 1')" "$drapes" \
    -- 'each has one result'
ok same_bits -- 'with the same bits as on one machine'

start w2
ok study 0.04 -- 'a study is accepted'
end_of_wait=$((SECONDS + 60))
until [ "$(tasks_done)" -ge 3 ] || [ $SECONDS -ge $end_of_wait ]; do sleep 0.02; done
end w3 KILL
note "worker host w3 died with $(tasks_done) tasks done"
ok wait_ended 200 -- 'the study ends'
ok same_numbers -- 'with the same bits as on one machine'
ok is "$(tasks_done)" 0 -- 'and leaves nothing behind'
start w3
[ "$drapes" -lt 1000 ] || ok measure_studies -- 'studies are spread over the hosts' # a figure
for host in api1 api2 w1 w2 w3; do
    ok end $host TERM -- "$host stops"
done
echo "1..$tests"
[ $failed -eq 0 ] || grep -hE '"level":"(error|warning)"' "$work"/*.log | cut -c1-300 | tail -n 20
exit $((failed > 0))
