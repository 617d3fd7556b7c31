"""Places of the values of unknown keys in a file: any may be a secret, so none is shown.

The tree of YAML nodes is followed beside the model, which also finds a key that is there twice, or
in a section refused as a whole.
"""

from __future__ import annotations

from collections.abc import Iterator

import yaml
from pydantic import BaseModel

from navigation.config.errors import model_in
from navigation.config.marks import compose


def values_of_unknown_keys(text: str, model: type[BaseModel]) -> list[tuple[int, int]]:
    """Their spans in the text; none if the text is not YAML."""
    try:
        root = compose(text)
    except (yaml.YAMLError, RecursionError):
        return []
    return [] if root is None else list(_spans(root, model, seen=set()))


def _spans(
    node: yaml.Node, model: type[BaseModel] | None, seen: set[tuple[int, type[BaseModel]]]
) -> Iterator[tuple[int, int]]:
    if model is None or (id(node), model) in seen:
        return
    seen.add((id(node), model))
    if isinstance(node, yaml.SequenceNode):
        for item in node.value:
            yield from _spans(item, model, seen)
    elif isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            field = model.model_fields.get(str(key.value))
            if field is None:
                yield value.start_mark.index, value.end_mark.index
            else:
                yield from _spans(value, model_in(field.annotation), seen)
