-- SPDX-License-Identifier: MIT
-- wrk: POSTs drapes, each another request than all before it, and counts the answers. The file
-- DRAPE is the request; SEED makes those of this run differ from those of others. With WAIT set a
-- call waits that many seconds for the end of its drape, and only results count.
local threads = {}
local file = assert(io.open(os.getenv("DRAPE")))
local head, tail = file:read("*a"):match('^(.*"spacing":)[%d.]+(.*)$')
file:close()
local wait = os.getenv("WAIT")

function setup(thread)
    table.insert(threads, thread)
    thread:set("lane", #threads)
end

function init()
    count, good, other = 0, 0, 0
    headers = {["Content-Type"] = "application/json"}
    if wait then
        headers["Prefer"] = "wait=" .. wait
    end
end

-- A spacing that is a little larger each time: too little to change the number of cells.
function request()
    count = count + 1
    local spacing = 0.1 * (1 + 1e-10 * (count * 64 + lane) + 1e-4 * os.getenv("SEED"))
    return wrk.format("POST", "/v1/drapes", headers, head .. string.format("%.15g", spacing) .. tail)
end

function response(status)
    if status == (wait and 200 or 202) then
        good = good + 1
    else
        other = other + 1
    end
end

function done(summary, latency)
    local good, other = 0, 0
    for _, thread in ipairs(threads) do
        good = good + thread:get("good")
        other = other + thread:get("other")
    end
    print(string.format("good %d other %d seconds %.3f p50_ms %.3f p99_ms %.3f", good,
        other + summary.errors.connect + summary.errors.read + summary.errors.timeout,
        summary.duration / 1e6, latency:percentile(50) / 1e3, latency:percentile(99) / 1e3))
end
