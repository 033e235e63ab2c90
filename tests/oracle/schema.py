"""Judges configurations by a JSON Schema with jsonschema, as an editor would.

  schema.py SCHEMA.json < CONFIGURATIONS

Standard input is a JSON list of texts in TOML. A line for each of them goes to standard output: "valid", or "refused"
and, with tabs between them, each error as its place in the file and its message. The schema itself has to be sound.
"""

import json
import sys

import jsonschema

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    import tomli as tomllib


def place(error):
    return ".".join(str(part) for part in error.absolute_path) or "the top level"


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        schema = json.load(file)
    validator = jsonschema.validators.validator_for(schema)
    assert validator is jsonschema.Draft7Validator, validator
    validator.check_schema(schema)
    judge = validator(schema)
    for text in json.load(sys.stdin):
        errors = [f"{place(error)}: {error.message}" for error in judge.iter_errors(tomllib.loads(text))]
        print("\t".join(["refused", *(" ".join(error.split()) for error in errors)]) if errors else "valid")


if __name__ == "__main__":
    main()
