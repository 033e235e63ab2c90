"""Tries the alert rules of Prometheus on scrapes of the gateway, and reads a dashboard of Grafana.

  alerts.py RULES DASHBOARD < SCRAPES

Standard input is a JSON object of cases, each a list of scrapes: `t` (s), `up`, and `text` as the
gateway served it (OpenMetrics; not there while it is not up). Writes a JSON object: of each case the
names of the alerts that fire at its last scrape, having been true for as long as they ask for, and the number of the
dashboard's queries, each of which asks for what the gateway serves.

The YAML is read by PyYAML, PromQL by the parser of promql-parser, the text by Prometheus' own client.
Evaluated is the part of PromQL that the rules use; whatever else they may use is refused.
"""

import json
import operator
import re
import sys

import promql_parser as promql
import yaml
from prometheus_client.openmetrics.parser import text_string_to_metric_families

COMPARISONS = {"==": operator.eq, "!=": operator.ne, ">": operator.gt, "<": operator.lt,
               ">=": operator.ge, "<=": operator.le}
ARITHMETIC = {"+": operator.add, "-": operator.sub, "*": operator.mul}
JOB = {"job": "tertius", "instance": "127.0.0.1:9481"}
UNITS = {"s": 1, "m": 60, "h": 3600, "d": 86400}


def rules(document):
    """All rules of the groups, as Prometheus would load them."""
    found = []
    for group in yaml.safe_load(document)["groups"]:
        assert group["name"], "a group without a name"
        for rule in group["rules"]:
            assert set(rule) <= {"alert", "expr", "for", "labels", "annotations"}, rule
            found.append((rule["alert"], promql.parse(rule["expr"]), wait(rule.get("for"))))
    assert found, "there is no group of rules"
    return found


def queries(dashboard):
    """The queries of a dashboard, its variables for all."""
    targets = (target for panel in dashboard["panels"] for target in panel["targets"])
    return [promql.parse(re.sub(r"\$\w+", ".*", target["expr"])) for target in targets]


def wait(text):
    if text is None:
        return 0
    number, unit = re.fullmatch(r"(\d+)([smhd])", text).groups()
    return int(number) * UNITS[unit]


def names(node):
    """The metrics that an expression asks for."""
    if isinstance(node, promql.VectorSelector):
        return {node.name}
    parts = [getattr(node, key, None) for key in ("lhs", "rhs", "expr", "vector_selector")]
    parts += getattr(node, "args", None) or []
    return set().union(*(names(part) for part in parts if part is not None))


def families(text):
    """The names of samples that the gateway may serve: of every family that it describes."""
    found = {"up"}
    for family in text_string_to_metric_families(text):
        found |= {family.name, family.name + "_total", family.name + "_count"}
    return found


class Scrape:
    def __init__(self, t, up, text=None):
        self.t = t
        self.samples = [("up", dict(JOB), float(up))]
        if up:
            for family in text_string_to_metric_families(text):
                self.samples += [(s.name, {**s.labels, **JOB}, float(s.value))
                                 for s in family.samples]


def key(labels, without=()):
    return tuple(sorted(item for item in labels.items() if item[0] not in without))


def matches(selector, name, labels):
    if name != selector.name:
        return False
    for matcher in selector.matchers.matchers:
        value, kind = labels.get(matcher.name, ""), str(matcher.op).rpartition(".")[2]
        fits = {"Equal": value == matcher.value, "NotEqual": value != matcher.value,
                "Re": bool(re.fullmatch(matcher.value, value)),
                "NotRe": not re.fullmatch(matcher.value, value)}
        if not fits[kind]:
            return False
    return True


class Moment:
    """The newest of `scrapes`, with those before."""

    def __init__(self, scrapes):
        self.scrapes, self.now = scrapes, scrapes[-1]

    def value(self, node):
        """A number, or the values by their labels (without the name)."""
        handler = getattr(self, type(node).__name__)
        return handler(node)

    def NumberLiteral(self, node):
        return node.val

    def ParenExpr(self, node):
        return self.value(node.expr)

    def VectorSelector(self, node):
        return {key(labels): value for name, labels, value in self.now.samples
                if matches(node, name, labels)}

    def Call(self, node):
        if node.func.name == "time":
            return self.now.t
        assert node.func.name == "increase", node.func.name
        (window,) = node.args
        since = self.now.t - window.range.total_seconds()
        series = {}
        for scrape in self.scrapes:
            for name, labels, value in scrape.samples:
                if scrape.t >= since and matches(window.vector_selector, name, labels):
                    series.setdefault(key(labels), []).append(value)
        # Prometheus extrapolates to the whole window, which changes no sign.
        return {labels: values[-1] - values[0] for labels, values in series.items()
                if len(values) > 1}

    def AggregateExpr(self, node):
        assert str(node.op) == "sum" and node.modifier.type == promql.AggModifierType.Without
        sums = {}
        for labels, value in self.value(node.expr).items():
            left = key(dict(labels), node.modifier.labels)
            sums[left] = sums.get(left, 0.0) + value
        return sums

    def BinaryExpr(self, node):
        op, left, right = str(node.op), self.value(node.lhs), self.value(node.rhs)
        if op == "or":
            return {**right, **left}
        if op == "and":
            # Prometheus compares all labels unless it is told which.
            assert not str(node.modifier or "").strip(), node.modifier
            return {labels: value for labels, value in left.items() if labels in right}
        if isinstance(left, dict) and isinstance(right, dict):
            raise AssertionError(f"{op} of two vectors")
        pairs = ({labels: (value, right) for labels, value in left.items()}
                 if isinstance(left, dict) else
                 {labels: (left, value) for labels, value in right.items()})
        if op in COMPARISONS:
            kept = left if isinstance(left, dict) else right
            return {labels: kept[labels] for labels, pair in pairs.items()
                    if COMPARISONS[op](*pair)}
        return {labels: ARITHMETIC[op](*pair) for labels, pair in pairs.items()}


def firing(found, scrapes):
    alerts = []
    for name, expression, lasts in found:
        since = None
        for count in range(1, len(scrapes) + 1):
            holds = bool(Moment(scrapes[:count]).value(expression))
            now = scrapes[count - 1].t
            since = (now if since is None else since) if holds else None
        if since is not None and scrapes[-1].t - since >= lasts:
            alerts.append(name)
    return sorted(alerts)


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        found = rules(file.read())
    with open(sys.argv[2], encoding="utf-8") as file:
        asked = queries(json.load(file))
    cases = json.load(sys.stdin)
    served = set()
    for scrapes in cases.values():
        for scrape in scrapes:
            served |= families(scrape["text"]) if scrape["up"] else set()
    for name, expression, _ in found:
        unknown = names(expression) - served
        assert not unknown, f"{name} asks for {unknown}, which the gateway does not serve"
    for query in asked:
        unknown = names(query) - served
        assert not unknown, f"the dashboard asks for {unknown}, which the gateway does not serve"
    result = {case: firing(found, [Scrape(**scrape) for scrape in scrapes])
              for case, scrapes in cases.items()}
    json.dump({"rules": [name for name, *_ in found], "firing": result,
               "queries": len(asked)}, sys.stdout)


main()
