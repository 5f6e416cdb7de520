"""Write the address of the repository everywhere it belongs, or check that before a release.

python .ci/address.py https://github.com/OWNER/ringwear    writes it
python .ci/address.py --check v0.1.0                       refuses a release without it, or of
                                                           another version
"""

import re
import sys
import tomllib
from pathlib import Path
from urllib.parse import urlsplit

ROOT = Path(__file__).parents[1]
README, CITATION, PROJECT = (
    ROOT / name for name in ("README.md", "CITATION.cff", "pyproject.toml")
)
# a link or a picture of Markdown whose target is a file of the repository
RELATIVE = re.compile(r"(!?)\[([^\]]*)\]\((?!https?://|#|mailto:)([^)\s]+)\)")
BRANCH = "main"
URLS = "[project.urls]"


def site_of(address: str) -> str:
    """Return the address of the site that a workflow publishes for a repository on GitHub."""
    owner, name = urlsplit(address).path.strip("/").split("/")
    return f"https://{owner.lower()}.github.io/{name}/"


def with_absolute_links(text: str, address: str) -> str:
    """Return Markdown whose relative links and pictures point to the repository."""

    def absolute(match: re.Match[str]) -> str:
        picture, words, target = match.groups()
        kind = "raw" if picture else "blob"
        return f"{picture}[{words}]({address}/{kind}/{BRANCH}/{target})"

    return RELATIVE.sub(absolute, text)


def with_urls(text: str, address: str) -> str:
    """Return pyproject.toml with the addresses of the project, instead of earlier ones."""
    rest = re.sub(rf"{re.escape(URLS)}\n(?:[^\[\n]*\n)*", "", text)
    urls = {
        "Repository": address,
        "Documentation": site_of(address),
        "Changelog": f"{address}/blob/{BRANCH}/CHANGELOG.md",
        "Issues": f"{address}/issues",
    }
    table = "\n".join([URLS, *(f'{name} = "{url}"' for name, url in urls.items())])
    return rest.replace("[project.scripts]", f"{table}\n\n[project.scripts]", 1)


def with_code(text: str, address: str) -> str:
    """Return CITATION.cff with the address of the code and of the site."""
    rest = re.sub(r"^(repository-code|url): .*\n", "", text, flags=re.MULTILINE)
    lines = f"repository-code: {address}\nurl: {site_of(address)}\n"
    return rest.replace("license: ", f"{lines}license: ", 1)


def write(address: str) -> None:
    """Write the address into the metadata, the README and the citation."""
    address = address.rstrip("/")
    if not re.fullmatch(r"https://github\.com/[\w.-]+/[\w.-]+", address):
        raise SystemExit(f"{address}: give the address as https://github.com/OWNER/ringwear")
    PROJECT.write_text(with_urls(PROJECT.read_text("utf-8"), address), "utf-8")
    README.write_text(with_absolute_links(README.read_text("utf-8"), address), "utf-8")
    CITATION.write_text(with_code(CITATION.read_text("utf-8"), address), "utf-8")


def check(tag: str) -> None:
    """Refuse a release whose metadata have no address, or whose tag is not the version."""
    project = tomllib.loads(PROJECT.read_text("utf-8"))["project"]
    if "urls" not in project:
        raise SystemExit(
            "the address of the repository is not known: run python .ci/address.py with it"
        )
    if RELATIVE.search(README.read_text("utf-8")):
        raise SystemExit("README.md has relative links, which an index breaks: run .ci/address.py")
    if tag != f"v{project['version']}":
        raise SystemExit(f"the tag is {tag}, and the version is {project['version']}")


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["--check", tag]:
            check(tag)
        case [address]:
            write(address)
        case _:
            raise SystemExit(__doc__)
