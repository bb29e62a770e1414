"""The metrics of an experiment with one row per run, or per point of its sweep."""

from __future__ import annotations

from typing import Any, Dict, List, Literal, Mapping, Sequence, Tuple

By = Literal["run", "point"]
Row = Dict[str, Any]


def rows(metrics: Sequence[Mapping[str, Any]], names: Sequence[str], by: By) -> List[Row]:
    """A row per run or point from a row per metric; `names` are those of the coordinates."""
    of_runs = [metric for metric in metrics if metric["scope"] == "run"]
    if by == "run":
        runs: Dict[str, Row] = {}
        for metric in of_runs:
            start = {**_coordinates(metric, names), "replicate": metric["replicate"], "file": metric["file"]}
            runs.setdefault(str(metric["file"]), start)[str(metric["metric"])] = metric["value"]
        return list(runs.values())
    points: Dict[Tuple[Any, ...], List[Mapping[str, Any]]] = {}
    # Of many runs, there are only the means.
    for metric in of_runs or [metric for metric in metrics if metric["along"] is None]:
        points.setdefault(_place(metric, names), []).append(metric)
    means: Dict[Tuple[Any, ...], Dict[str, Mapping[str, Any]]] = {}
    for metric in metrics:
        if metric["scope"] == "sweep":
            means.setdefault(_place(metric, names), {})[str(metric["metric"])] = metric
    return [_point(found, names, means.get(place, {})) for place, found in points.items()]


def points_of_single_runs(columns: Mapping[str, List[Any]]) -> Dict[str, List[Any]]:
    """The columns of runs without replicates, of which each is a point."""
    start = list(columns).index("replicate")
    points = {name: values for name, values in list(columns.items())[:start]}
    points["replicates"] = [1] * len(columns["replicate"])
    points.update({name: values for name, values in columns.items() if name not in points and name not in ("replicate", "file")})
    return points


def _point(found: Sequence[Mapping[str, Any]], names: Sequence[str], means: Mapping[str, Mapping[str, Any]]) -> Row:
    """The means of a point; a metric without a mean has the value of the only run."""
    row = _coordinates(found[0], names)
    replicates = found[0]["replicates"] or len({metric["file"] for metric in found})
    row["replicates"] = replicates
    own = {str(metric["metric"]): metric for metric in found}
    # Fits of a single point are those of the whole sweep.
    for name in own:
        metric = means.get(name) or (own[name] if replicates == 1 else {})
        row[name] = metric.get("value")
        if name in means:
            row[f"{name}.standard_error"] = metric.get("standard_error")
    return row


def _coordinates(metric: Mapping[str, Any], names: Sequence[str]) -> Row:
    return {name: metric["coordinates"].get(name) for name in names}


def _place(metric: Mapping[str, Any], names: Sequence[str]) -> Tuple[Any, ...]:
    return tuple(metric["coordinates"].get(name) for name in names)
