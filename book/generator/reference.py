"""The manifest reference, from the JSON Schema that the program generates from the tables by which it parses manifests."""

import json

MODELS = {"dem": "DEM", "gas": "Gas", "packing": "Packing", "orbit": "Orbit"}
TABLES = ("record", "sweep", "checks", "plots", "baseline", "exercise")


def in_cell(text):
    return text.replace("|", "\\|").replace("\n", " ")


def resolve(schema, root):
    """Follows references within the schema."""
    while "$ref" in schema:
        target = root
        for part in schema["$ref"].removeprefix("#/").split("/"):
            target = target[part]
        schema = target
    return schema


def kind(schema, root):
    """The type of a value, in words."""
    schema = resolve(schema, root)
    if "const" in schema:
        return f"`{json.dumps(schema['const'])}`"
    if "enum" in schema:
        return " or ".join(f"`{json.dumps(value)}`" for value in schema["enum"])
    for several in ("anyOf", "oneOf"):
        if several in schema:
            return "; or ".join(dict.fromkeys(kind(one, root) for one in schema[several]))
    given = schema.get("type", "value")
    if isinstance(given, list):
        return " or ".join(given)
    if given == "array":
        size = f"{schema['minItems']} " if schema.get("minItems") and schema.get("minItems") == schema.get("maxItems") else ""
        item = kind(schema.get("items", {}), root)
        return f"list of {size}{'tables' + item.removeprefix('table') if item.startswith('table') else item}"
    if given == "object" and schema.get("properties"):
        return "table of " + ", ".join(f"`{name}`" for name in schema["properties"])
    return {"string": "text", "object": "table", "boolean": "`true` or `false`"}.get(given, given)


def limits(schema, root):
    """The range of a number, in words."""
    schema = resolve(schema, root)
    words = [f"{sign} {json.dumps(schema[name])}" for name, sign in
             (("minimum", "≥"), ("exclusiveMinimum", ">"), ("maximum", "≤"), ("exclusiveMaximum", "<")) if name in schema]
    return ", ".join(words)


def rows(table, root):
    """One row per key of a table."""
    lines = ["| key | meaning | value | default |", "|---|---|---|---|"]
    needed = table.get("required", [])
    for name, schema in table.get("properties", {}).items():
        whole = resolve(schema, root)
        default = f"`{json.dumps(whole['default'], ensure_ascii=False)}`" if "default" in whole else ""
        default = "required" if name in needed else default
        value, range_text = kind(schema, root), limits(schema, root)
        value = f"{value}, {range_text}" if range_text else value
        meaning = schema.get("description", whole.get("description", ""))
        lines.append(f"| `{name}` | {in_cell(meaning)} | {in_cell(value)} | {in_cell(default)} |")
    return "\n".join(lines)


def keys_of(schema, root):
    """The table of a schema that may be an array of tables."""
    schema = resolve(schema, root)
    return resolve(schema["items"], root) if schema.get("type") == "array" else schema


def manifest_reference(schema):
    """The page."""
    root = schema
    top = schema["properties"]
    parts = ["""# Manifest reference

Every key of a manifest, from the JSON Schema that `kinetoscope schema` prints. The schema is generated from the tables by which the
program parses manifests, and this page from the schema. `kinetoscope new MODEL` prints a manifest with the keys of the model, their units and defaults.

## Top level
""", rows({"properties": {name: value for name, value in top.items() if name not in ("model", *TABLES)}}, root)]
    models = resolve(top["model"], root)["properties"]
    for name, title in MODELS.items():
        if name in models:
            parts += [f"\n## [model.{name}]: {title}\n", rows(keys_of(models[name], root), root)]
    for name in TABLES:
        if name in top:
            brackets = f"[[{name}]]" if resolve(top[name], root).get("type") == "array" else f"[{name}]"
            parts += [f"\n## {brackets}\n", rows(keys_of(top[name], root), root)]
    return "\n".join(parts) + "\n"
