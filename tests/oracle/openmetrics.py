"""Parses OpenMetrics text from standard input as Prometheus' own Python client does, which is strict.
Writes a JSON list: family, type, help, sample, labels, value; bounds of histograms as %g has them."""

import json
import sys

from prometheus_client.openmetrics.parser import text_string_to_metric_families

samples = []
for family in text_string_to_metric_families(sys.stdin.read()):
    for sample in family.samples:
        if "le" in sample.labels:
            sample.labels["le"] = f"{float(sample.labels['le']):g}"
        samples.append(
            {
                "family": family.name,
                "type": family.type,
                "help": family.documentation,
                "name": sample.name,
                "labels": sample.labels,
                "value": float(sample.value),
            }
        )
json.dump(samples, sys.stdout, allow_nan=False)
