"""Generates the source of the book: `python3 book/generator --help`."""

import argparse
import concurrent.futures
import json
import shutil
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import laws as law_book
import pages
import pictures
import reference
from assemble import Assembly, SourceError, escape_angles
from execution import ExecutionError, Pages
from formulas import FormulaError

BOOK = Path(__file__).resolve().parents[1]
REPOSITORY = BOOK.parent


def arguments():
    parser = argparse.ArgumentParser(prog="python3 book/generator", description="Generate the source of the book with all its numbers.")
    parser.add_argument("--bin", type=Path, default=REPOSITORY / "target/release", help="folder of the programs [default: target/release]")
    parser.add_argument("--output", type=Path, default=REPOSITORY / "target/book", help="folder of the book [default: target/book]")
    parser.add_argument("--quick", action="store_true", help="one law per model")
    parser.add_argument("--cross-code-python", default=sys.executable, metavar="PYTHON",
                        help="a Python in which the packages of book/cross_code/requirements.txt are installed [default: this one]")
    parser.add_argument("--law", action="append", default=[], metavar="ID", help="only this law, and nothing else; prints its comparison")
    return parser.parse_args()


def measure_and_draw(law, options):
    """The result of a law, whose pictures and replay are in the folder `laws/shown`, unless only its comparison is wanted."""
    programs, folder = options.bin.resolve(), options.output / "laws"
    result = law_book.measure(law, programs, folder, replay=not options.law)
    if not options.law:
        pictures.draw(result, programs, folder / "recordings", folder / "shown")
    return result


def measure_all(laws, options):
    """Runs the laws, two at a time, and returns their results and what is wrong with them."""
    results, wrong = [], []
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        waiting = [(law, pool.submit(measure_and_draw, law, options)) for law in laws]
        for law, result in waiting:
            try:
                results.append(result.result())
            except law_book.LawError as error:
                wrong.append(str(error))
                continue
            wrong += [f"{law['id']}: {failure}" for failure in results[-1].failures()]
    return results, wrong


def write_laws(laws, results, source, shown, seconds):
    """Writes the pages of the laws, and returns their lines of the summary."""
    folder = source / "laws"
    shutil.copytree(shown, folder)
    lines = [f"  - [{pages.MODELS[law['model']]}: {law['title']}](laws/{law['id']}.md)" for law in laws]
    for law in laws:
        (folder / f"{law['id']}.md").write_text(pages.unmeasured_page(law))
    for result in results:
        manifest = law_book.manifest_text(result.law)
        (folder / f"{result.law['id']}.toml").write_text(manifest)
        (folder / f"{result.law['id']}.md").write_text(pages.law_page(result, manifest))
    (folder / "index.md").write_text(pages.index_page(results, seconds))
    if faults := pages.incomplete_pages(laws, results, folder):
        raise SourceError("\n".join(faults))
    return lines


def write_cross_code(source, options):
    """Writes the pages that compare with other programs, and returns their lines of the summary."""
    folder = source / "cross_code"
    folder.mkdir(parents=True, exist_ok=True)
    command = [options.cross_code_python, BOOK / "cross_code", "--bin", options.bin.resolve(), "--output", folder]
    done = subprocess.run(command)
    if done.returncode:
        raise SourceError(f"the cross-code pages failed with exit code {done.returncode}")
    return [f"  - [{title}](cross_code/{name})" for name, title in json.loads((folder / "pages.json").read_text())]


def print_points(results):
    for result in results:
        print(result.law["id"])
        for name, points in (("law", result.points), ("control", result.control_points)):
            for point in points:
                print(f"  {name:8} {point.label:30} measured {point.measured:<24.10g} exact {point.exact:<24.10g} "
                      f"expected deviation {point.expected:<10.3g} tolerance {point.tolerance:<10.3g} "
                      f"deviation / tolerance {point.deviation():.3g}")


def main():
    options = arguments()
    started = time.monotonic()
    try:
        laws = law_book.read_laws(BOOK / "laws")
    except law_book.LawError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    if options.law:
        chosen = [law for law in laws if law["id"] in options.law]
    elif options.quick:
        chosen = [next(law for law in laws if law["model"] == model) for model in pages.MODELS]
    else:
        chosen = laws
    if not options.law:
        # Every number comes from runs of this build.
        shutil.rmtree(options.output / "laws", ignore_errors=True)
    results, wrong = measure_all(chosen, options)
    seconds = time.monotonic() - started
    print(f"{len(results)} laws and their controls in {seconds:.0f} s")
    if options.law:
        print_points(results)
    if wrong:
        print("\n".join(f"error: {text}" for text in wrong), file=sys.stderr)
        return 1
    if options.law:
        return 0
    source = options.output / "src"
    shutil.rmtree(source, ignore_errors=True)
    try:
        execution = Pages(REPOSITORY, options.bin.resolve(), (options.output / "executed").resolve())
        Assembly(REPOSITORY, BOOK / "src", source.resolve()).assemble(execution.execute)
        lines = {"laws": write_laws(laws, results, source, options.output / "laws/shown", seconds), "cross_code": write_cross_code(source, options)}
    except (SourceError, ExecutionError, FormulaError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    schema = subprocess.run([options.bin / "kinetoscope", "schema"], check=True, capture_output=True, text=True).stdout
    (source / "reference" / "manifest.md").write_text(reference.manifest_reference(json.loads(schema)))
    summary = source / "SUMMARY.md"
    text = summary.read_text()
    for name, generated in lines.items():
        text = text.replace(f"{{{{{name}}}}}", "\n".join(generated))
    summary.write_text(text)
    for page in source.rglob("*.md"):
        page.write_text(escape_angles(page.read_text()))
    shutil.copyfile(BOOK / "book.toml", options.output / "book.toml")
    print(f"source of the book in {options.output}, after {time.monotonic() - started:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
