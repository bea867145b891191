#!/bin/sh
# An experiment by curl: sh examples/experiment.sh [URL]
set -eu
url=${1:-http://127.0.0.1:8080}
cd "$(dirname "$0")"
field() { sed -E "s/.*\"$1\":\"?([^\",}]+).*/\1/"; }

made=$(curl -sf "$url/api/v1/experiments" -H 'Content-Type: application/json' --data-binary @experiment.json)
id=$(echo "$made" | field id)
key=$(echo "$made" | field owner_key)
until [ "$(curl -sf "$url/api/v1/experiments/$id" | field state)" = done ]; do sleep 0.2; done
curl -sf "$url/api/v1/experiments/$id/results?points=true" -H 'Accept: text/csv'
curl -sf -X DELETE "$url/api/v1/experiments/$id" -H "Authorization: Bearer $key"
