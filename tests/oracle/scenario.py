"""A scenario with all its defaults, from `laglab schema`; and live changes by dotted paths."""

import copy
import json
import subprocess


def schema_of(laglab):
    out = subprocess.run([laglab, "schema", "netgame"], capture_output=True, text=True, check=True).stdout
    return json.loads(out)


class Filler:
    def __init__(self, schema):
        self.root = schema
        self.top = next((s for s in schema.get("oneOf", [schema]) if s.get("title") == "netgame"), schema)

    def resolve(self, node):
        while "$ref" in node:
            target = self.root
            for part in node["$ref"].lstrip("#/").split("/"):
                target = target[part]
            node = {**target, **{k: v for k, v in node.items() if k != "$ref"}}
        return node

    def fill(self, given, node=None, game=None):
        node = self.resolve(node or self.top)
        out = {}
        for name, row in node.get("properties", {}).items():
            row = self.resolve(row)
            if name == "params":
                out[name] = self.fill(given.get(name, {}), self.root["$defs"][game])
            elif row.get("type") == "object" and name != "set":
                out[name] = self.fill(given.get(name, {}), row)
            elif row.get("type") == "array" and name == "players":
                out[name] = [self.fill(p, row["items"]) for p in given.get(name, ())]
            elif name in given:
                out[name] = copy.deepcopy(given[name])
            else:
                out[name] = copy.deepcopy(row.get("default"))
            if name == "game":
                game = out[name]
        return out


def change(scenario, path, value):
    """A live change. Reconciliation switches prediction on; prediction off switches reconciliation off."""
    *way, last = path.split(".")
    node = scenario
    for part in way:
        node = node[int(part)] if isinstance(node, list) else node[part]
    node[last] = value
    if last == "reconciliation" and value:
        node["prediction"] = True
    if last == "prediction" and not value:
        node["reconciliation"] = False
