#!/usr/bin/env python3
"""Is a bundle a Process Run Crate without required or recommended findings? By the validator of the RO-Crate community.

    tests/interop/research_object.py BUNDLE.zip
    tests/interop/research_object.py BUNDLE.zip CONTEXT_OF_RO_CRATE CONTEXT_OF_WORKFLOW_RUN    # without a network

The contexts are docs/_specification/1.1/context.jsonld of ResearchObject/ro-crate and workflow-run/context.json of
ResearchObject/ro-terms. Control: the same crate without its license and its action has findings.
Package: roc-validator 0.13.

Exit codes: 0 no finding, 1 findings, 77 the contexts cannot be reached.
"""

import io
import json
import pathlib
import sys
import tempfile
import zipfile

import requests
from requests.adapters import HTTPAdapter
from rocrate_validator import models, services
from urllib3 import HTTPResponse

ADDRESSES = ("https://w3id.org/ro/crate/1.1/context", "https://w3id.org/ro/terms/workflow-run/context")
PROFILE = "process-run-crate"


def serve(contexts):
    """Answers the validator's requests for the contexts from files, and refuses all others."""
    pages = dict(zip(ADDRESSES, contexts))

    def send(_adapter, request, **_options):
        if request.url.rstrip("/") not in pages:
            raise requests.ConnectionError(request.url)
        response = requests.Response()
        response.status_code, response.url, response.request = 200, request.url, request
        response.headers["Content-Type"] = "application/ld+json"
        body = io.BytesIO(pathlib.Path(pages[request.url.rstrip("/")]).read_bytes())
        response.raw = HTTPResponse(body=body, headers=response.headers, status=200, preload_content=False)
        return response

    HTTPAdapter.send = send


def findings(folder):
    settings = services.ValidationSettings(
        rocrate_uri=str(folder), profile_identifier=PROFILE, requirement_severity=models.Severity.RECOMMENDED, no_cache=True
    )
    issues = services.validate(settings).get_issues()
    return [f"{issue.severity.name} {issue.check.identifier}: {issue.message}" for issue in issues]


def main():
    bundle, contexts = sys.argv[1], sys.argv[2:]
    if contexts:
        serve(contexts)
    else:
        try:
            requests.head(ADDRESSES[0], timeout=30).raise_for_status()
        except requests.RequestException:
            return 77
    with tempfile.TemporaryDirectory() as folder:
        zipfile.ZipFile(bundle).extractall(folder)
        found = findings(folder)
        print("\n".join(found) or f"{bundle}: no required and no recommended finding")
        metadata = pathlib.Path(folder) / "ro-crate-metadata.json"
        crate = json.loads(metadata.read_text())
        for entity in crate["@graph"]:
            entity.pop("license", None)
            entity.pop("instrument", None)
        metadata.write_text(json.dumps(crate))
        assert len(findings(folder)) >= 2, "control: a crate without license and instrument has no finding"
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
