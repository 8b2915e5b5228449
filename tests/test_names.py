"""One class name means one thing."""

import ast
from collections import Counter
from pathlib import Path

import imugap

ROOT = Path(imugap.__file__).parent


def test_no_two_classes_have_the_same_name():
    trees = (ast.parse(path.read_text()) for path in ROOT.rglob("*.py"))
    names = Counter(node.name for tree in trees for node in tree.body if isinstance(node, ast.ClassDef))
    assert not [name for name, count in names.items() if count > 1]
