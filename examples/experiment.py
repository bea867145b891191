#!/usr/bin/env python3
"""An experiment with nothing but the standard library: python3 examples/experiment.py [URL]"""
import json
import pathlib
import sys
import time
import urllib.request

URL = sys.argv[1].rstrip("/") if len(sys.argv) > 1 else "http://127.0.0.1:8080"


def call(method, path, body=None, **headers):
    data = None if body is None else json.dumps(body).encode()
    if data:
        headers["Content-Type"] = "application/json"
    request = urllib.request.Request(URL + path, data, headers, method=method)
    with urllib.request.urlopen(request) as answer:
        return answer.read().decode()


experiment = json.loads(pathlib.Path(__file__).with_name("experiment.json").read_text())
made = json.loads(call("POST", "/api/v1/experiments", experiment))
path = made["links"]["self"]
while json.loads(call("GET", path))["state"] != "done":
    time.sleep(0.2)
sys.stdout.write(call("GET", path + "/results?points=true", Accept="text/csv"))
call("DELETE", path, Authorization="Bearer " + made["owner_key"])
