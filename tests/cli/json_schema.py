"""Checks a value by a JSON schema of docs/schemas, in the words that those schemas use; any other word is an error, so that
none is silently ignored. Where the jsonschema package is installed, it has to agree."""

import json
import os

try:
    import jsonschema
except ImportError:
    jsonschema = None

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "docs", "schemas")
TYPES = {
    "object": lambda v: isinstance(v, dict),
    "array": lambda v: isinstance(v, list),
    "string": lambda v: isinstance(v, str),
    "boolean": lambda v: isinstance(v, bool),
    "number": lambda v: isinstance(v, (int, float)) and not isinstance(v, bool),
    "integer": lambda v: isinstance(v, int) and not isinstance(v, bool),
    "null": lambda v: v is None,
}
WORDS = {"$schema", "$defs", "title", "description", "$ref", "type", "enum", "minimum", "maximum", "exclusiveMinimum", "minItems", "maxItems"}
WORDS |= {"items", "properties", "required", "additionalProperties", "oneOf"}


def load(name):
    with open(os.path.join(FOLDER, name + ".schema.json"), encoding="utf-8") as file:
        return json.load(file)


def problems(value, schema, root=None, path=""):
    """What breaks the schema, as a list of sentences."""
    root = root or schema
    found = ["%s: unknown word %s" % (path, word) for word in schema if word not in WORDS]
    if "$ref" in schema:
        found += problems(value, root["$defs"][schema["$ref"][len("#/$defs/") :]], root, path)
    if "oneOf" in schema and sum(not problems(value, option, root, path) for option in schema["oneOf"]) != 1:
        found.append(path + ": matches not one of oneOf")
    if "type" in schema and not TYPES[schema["type"]](value):
        return found + ["%s: %r is not of type %s" % (path, value, schema["type"])]
    if "enum" in schema and value not in schema["enum"]:
        found.append("%s: %r is not in enum" % (path, value))
    if "minimum" in schema and value < schema["minimum"] or "maximum" in schema and value > schema["maximum"]:
        found.append("%s: %r is outside its limits" % (path, value))
    if "exclusiveMinimum" in schema and value <= schema["exclusiveMinimum"]:
        found.append("%s: %r is not above its limit" % (path, value))
    if isinstance(value, list):
        if not schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value)):
            found.append("%s: has %d items" % (path, len(value)))
        for i, item in enumerate(value if "items" in schema else []):
            found += problems(item, schema["items"], root, "%s/%d" % (path, i))
    if isinstance(value, dict):
        found += ["%s: lacks %s" % (path, key) for key in schema.get("required", []) if key not in value]
        for key, member in value.items():
            if key in schema.get("properties", {}):
                found += problems(member, schema["properties"][key], root, path + "/" + key)
            elif schema.get("additionalProperties", True) is False:
                found.append("%s: unknown member %s" % (path, key))
    return found


def check(value, name):
    """Problems of a value by docs/schemas/NAME.schema.json."""
    schema = load(name)
    found = problems(value, schema)
    if jsonschema is not None:
        theirs = [error.message for error in jsonschema.Draft202012Validator(schema).iter_errors(value)]
        if bool(theirs) != bool(found):
            found.append("jsonschema disagrees: %s" % theirs)
    return found
