"""Which modules of this package, or of others, a script runs: what a workflow watches besides the script itself."""

import ast
from collections.abc import Iterable
from functools import cache
from hashlib import sha256
from pathlib import Path

PACKAGE = Path(__file__).parents[1]


def modules_of(script: str | Path, *packages: str | Path) -> list[Path]:
    """Return the files of ``packages`` (by default this one) that a script imports, directly or not, sorted."""
    roots = tuple(map(Path, packages)) or (PACKAGE,)
    found: set[Path] = set()
    pending = [Path(script)]
    while pending:
        new = _imported(pending.pop(), roots) - found
        found |= new
        pending += new
    return sorted(found)


def digest(modules: Iterable[Path] | None = None) -> str:
    """Return a short digest of what the modules contain, by default all of this package.

    A compiled kernel that is inlined into another module's kernel is cached with that module's file, and an edit of its
    own file would go unnoticed: caches are kept apart by the digest of the package.
    """
    sources = sorted(PACKAGE.rglob("*.py") if modules is None else modules)
    return sha256(b"".join(source.read_bytes() for source in sources)).hexdigest()[:16]


@cache
def _imported(source: Path, packages: tuple[Path, ...]) -> frozenset[Path]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(source.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level > 0:
            raise ValueError(f"{source}, line {node.lineno}: expected an absolute import; found a relative one")
        elif isinstance(node, ast.ImportFrom):
            names |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    roots = {package.name: package for package in packages}
    parts = (name.split(".") for name in names)
    return frozenset(file for root, *rest in parts if root in roots for file in _files(rest, roots[root]))


def _files(parts: list[str], package: Path) -> list[Path]:
    """Return the files that importing ``parts`` below ``package`` runs: each package on the way, and the module."""
    packages = [package.joinpath(*parts[:depth], "__init__.py") for depth in range(len(parts) + 1)]
    module = package.joinpath(*parts).with_suffix(".py")
    return [file for file in (*packages, module) if file.is_file()]
