"""Parser of ``.idl`` files, the other form in which packages define interfaces.

The grammar is that of rosbags, which drops annotations, including default values, and the position
of an error.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple, cast

from rosbags.typesys.base import BaseName, BaseType, Cardinality, Field as IdlField, TypesysError
from rosbags.typesys.idl import (
    Annotation,
    ExpType,
    IDLParser,
    Member,
    Reference,
    Struct,
    eval_expression,
)
from rosbags.typesys.peg import Failure, Success

from teleopctl.errors import InvalidDefinitionError
from teleopctl.interfaces.definition import (
    IDL_ONLY,
    PLACEHOLDER,
    Constant,
    Definition,
    Field,
    FieldType,
    Shape,
)
from teleopctl.interfaces.parser import parse
from teleopctl.interfaces.services import (
    ACTION_PARTS,
    SERVICE_PARTS,
    action_types,
    service_types,
)
from teleopctl.interfaces.typenames import split

if TYPE_CHECKING:
    from rosbags.typesys.idl import ConstDecl, Expression
    from rosbags.typesys.peg import Result

_INCLUDE = re.compile(r"^[ \t]*#include[ \t]+[<\"]([^>\"\n]+)[>\"][^\n]*$", re.MULTILINE)
_FIELD_NAME = re.compile(r"[a-z][A-Za-z0-9_]*\Z")
# Escape sequences of strings that are not wide.
_ESCAPE = re.compile(r"\\(?:[0-7]{1,3}|x[0-9A-Fa-f]{2}|[nvtbrfa\\'\"])")
_FIXED_POINT = r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)[dD]"
# Types that messages do not have; IDL's char differs from that of messages.
_IDL_ONLY = {"char": "char", "wchar": "wchar", "float128": "long double"}
_WHOLE = ExpType(BaseType(BaseName.INT64))
_PARTS = {"msg": ("",), "srv": SERVICE_PARTS[:2], "action": ACTION_PARTS[:3]}


class IdlAnnotation(NamedTuple):
    """Annotation in an IDL file: name, and None, one value, or a dictionary of arguments."""

    name: str
    value: object = None


class IdlMember(NamedTuple):
    """Member of an IDL struct: name, type and annotations."""

    name: str
    type: FieldType
    annotations: tuple[IdlAnnotation, ...] = ()


class IdlStruct(NamedTuple):
    """Struct of an IDL file, with the constants of its module ``NAME_Constants``.

    Attributes:
        name: Name of the struct with its modules, as ``package/msg/Name``.
        members: Members in the order of the definition.
        constants: Constants in the order of the definition.
        annotations: Annotations of the struct, without those of members.
    """

    name: str
    members: tuple[IdlMember, ...]
    constants: tuple[Constant, ...]
    annotations: tuple[IdlAnnotation, ...]


class _AnnotatedMember(Member):
    """Member of a struct with its annotations."""

    annotations: tuple[IdlAnnotation, ...] = ()


class _Parser(IDLParser):
    """Parser that also stores annotations by struct name, and the furthest failed position."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.furthest = 0
        self.structs: dict[str, tuple[tuple[IdlAnnotation, ...], list[_AnnotatedMember]]] = {}
        self._constants: dict[str, Expression] = {}

    def literal(self, pos: int, text: str) -> Result[str]:
        return self._record_failure(super().literal(pos, text))

    def regex(self, pos: int, pattern: str, flags: int = 0) -> Result[str]:
        return self._record_failure(super().regex(pos, pattern, flags))

    def _record_failure(self, found: Result[str]) -> Result[str]:
        if isinstance(found, Failure):
            self.furthest = max(self.furthest, found.pos)
        return found

    def float_literal(self, pos: int) -> Result[float]:
        fixed = self.regex(pos, _FIXED_POINT)
        if isinstance(fixed, Success):
            return Success(fixed.pos, float(fixed.value[:-1]))
        return super().float_literal(pos)

    def positive_int_const(self, pos: int) -> Result[Expression]:
        # Without shifts: the end of `sequence<string<3>>` would be parsed as one.
        found = self.add_expr(pos)
        if isinstance(found, Success) and isinstance(found.value, Reference):
            # The constants of a struct are in a sibling module, not in an enclosing module.
            name = str(_evaluated(found.value)).rpartition("/")[2]
            return Success(found.pos, self._constants.get(name, found.value))
        return found

    def const_dcl(self, pos: int) -> Result[ConstDecl]:
        found = super().const_dcl(pos)
        if isinstance(found, Success):
            self._constants[found.value.name] = found.value.value
        return found

    def member(self, pos: int) -> Result[list[Member]]:
        found = super().member(pos)
        if isinstance(found, Failure):
            return found
        annotated: list[Member] = []
        for member in found.value:
            one = _AnnotatedMember(*member)
            one.annotations = self._annotations(pos)
            annotated.append(one)
        return Success(found.pos, annotated)

    def struct_def(self, pos: int) -> Result[Struct]:
        found = super().struct_def(pos)
        if isinstance(found, Success):
            members = cast("list[_AnnotatedMember]", found.value.fields)
            self.structs[found.value.name] = (self._annotations(pos), members)
        return found

    def _annotations(self, pos: int) -> tuple[IdlAnnotation, ...]:
        found = self.many0(pos, lambda p: self.all(p, (self.annotation_appl, self.space)))
        return tuple(_annotation(annotation) for annotation, _ in found.value)


def _annotation(annotation: Annotation) -> IdlAnnotation:
    if annotation.arg is None:
        return IdlAnnotation(annotation.name)
    values = {name: _evaluated(expression) for name, expression in annotation.arg}
    return IdlAnnotation(annotation.name, values.get("", values))


def _evaluated(expression: Expression) -> object:
    if isinstance(expression, Reference):
        return str(getattr(expression.name.ref, "name", expression.name.ref))
    return _plain(eval_expression(expression, _WHOLE, "", ()).value)


def _plain(value: object) -> object:
    """Return a value with the escapes of a text resolved."""
    if not isinstance(value, str):
        return value
    return _ESCAPE.sub(lambda found: found[0].encode().decode("unicode_escape"), value)


def idl_includes(text: str) -> list[str]:
    """Return the paths in the ``#include`` lines of an IDL file's text."""
    return _INCLUDE.findall(text)


def read_idl(text: str, where: str) -> list[IdlStruct]:
    """Return the structs, with constants and annotations, in the text of an IDL file.

    Args:
        text: Content of the file; included files are not read.
        where: Name of the text in error messages.

    Raises:
        InvalidDefinitionError: The text cannot be parsed; the message has the line number.
    """
    parser = _Parser(_INCLUDE.sub(lambda found: " " * len(found[0]), text))
    try:
        messages = parser.specification()
    except (TypesysError, SyntaxError, RecursionError) as error:
        reason = str(error)
        if reason.startswith("Could not parse"):
            line = text.count("\n", 0, parser.furthest) + 1
            rest = text[parser.furthest :].partition("\n")[0].strip()
            raise InvalidDefinitionError(f"{where}:{line}: this is no IDL: {rest!r}") from error
        raise InvalidDefinitionError(f"{where}: {reason}") from error
    structs = []
    for name, constants, fields in messages:
        annotations, members = parser.structs.get(name.rpartition("/")[2], ((), []))
        by_name = {member.name: member.annotations for member in members}
        structs.append(
            IdlStruct(
                name,
                tuple(IdlMember(f.name, _field_type(f), by_name.get(f.name, ())) for f in fields),
                tuple(Constant(c.name, c.typ.value, _plain(c.value)) for c in constants),
                annotations,
            )
        )
    return structs


def _field_type(field: IdlField) -> FieldType:
    reference, cardinality, text_bound, size = field.typ
    base = reference.name.value if isinstance(reference, BaseType) else reference.name
    if base in _IDL_ONLY:
        base = f"{IDL_ONLY}{_IDL_ONLY[base]}"
    shape = Shape.SINGLE
    if cardinality is Cardinality.ARRAY:
        shape = Shape.ARRAY
    elif cardinality is Cardinality.SEQUENCE:
        shape = Shape.BOUNDED if size else Shape.UNBOUNDED
    return FieldType(base, shape, size, text_bound)


def split_idl(text: str, type_name: str, where: str) -> list[Definition]:
    """Return the `Definition`s of a type in IDL; for services and actions with derived types.

    Args:
        text: Content of the file.
        type_name: Full name of the type, ``package/kind/Name``.
        where: Name of the text in error messages.

    Raises:
        InvalidDefinitionError: The text cannot be parsed, or lacks a struct of the type.
    """
    structs = {struct.name: struct for struct in read_idl(text, where)}
    kind = split(type_name)[1]
    names = [f"{type_name}_{part}" if part else type_name for part in _PARTS[kind]]
    for name in names:
        if name not in structs:
            raise InvalidDefinitionError(
                f"{where}: there is no struct {name.replace('/', '::')}",
                hint="The modules around it are named as the package and as msg, srv or action.",
            )
    parts = [_definition(structs[name], where, text) for name in names]
    whole = "---\n".join(part.render() for part in parts)
    if kind == "msg":
        return parts
    return [*parts, *(service_types if kind == "srv" else action_types)(type_name, whole)]


def _definition(struct: IdlStruct, where: str, text: str) -> Definition:
    """Return the definition of a struct; each line is checked as a line of a ``.msg`` file."""
    package = split(struct.name)[0]
    fields: list[Field] = []
    constants: list[Constant] = []
    lines = _comments(struct.annotations)
    for constant in struct.constants:
        lines.append(f"{constant.base} {constant.name}={_written(constant.value)}")
        with _located_errors(constant.name, struct, where, text):
            constants += parse(
                lines[-1], struct.name, split(struct.name)[0], first_line=0
            ).constants
    for member in struct.members:
        if member.name == PLACEHOLDER:
            continue
        lines += _comments(member.annotations)
        with _located_errors(member.name, struct, where, text):
            if member.name in {field.name for field in fields}:
                raise ValueError("the name is given twice")
            kind, default = _line(member)
            lines.append(f"{kind} {member.name}{default}")
            plain = f"{kind} {member.name.lower()}{default}"
            (field,) = parse(plain, struct.name, package, first_line=0).fields
            fields.append(field._replace(name=member.name))
    written = "".join(f"{line}\n" for line in lines)
    return Definition(struct.name, tuple(fields), tuple(constants), written)


@contextmanager
def _located_errors(name: str, struct: IdlStruct, where: str, text: str) -> Iterator[None]:
    """Raise errors of a member or constant with the file, line number and name of the member."""
    try:
        yield
    except (InvalidDefinitionError, ValueError, SyntaxError) as error:
        begin = max(0, text.find(split(struct.name)[2]))
        place = re.search(rf"\b{name}\b", text[begin:])
        line = text.count("\n", 0, begin + (place.start() if place else 0)) + 1
        reason = str(error).partition(":0: ")[2] or str(error)
        raise InvalidDefinitionError(f"{where}:{line}: {name}: {reason}") from error


def _line(member: IdlMember) -> tuple[str, str]:
    """Return type and default value of a field as a ``.msg`` file has them."""
    kind = member.type
    if kind.base.startswith(IDL_ONLY):
        raise ValueError(f"{kind.base.removeprefix(IDL_ONLY)} is not served in messages")
    if not _FIELD_NAME.match(member.name):
        raise ValueError("the name of a field begins with a small letter")
    value = next((a.value for a in member.annotations if a.name == "default"), None)
    if isinstance(value, dict):
        value = value.get("value")
    if value is None:
        return str(kind), ""
    if kind.shape is not Shape.SINGLE and isinstance(value, str):
        value = ast.literal_eval(value)  # IDL has no lists: the value is a string
    return str(kind), f" {_written(value)}"


def _comments(annotations: tuple[IdlAnnotation, ...]) -> list[str]:
    texts = [
        str(a.value.get("text", ""))
        for a in annotations
        if a.name == "verbatim"
        and isinstance(a.value, dict)
        and a.value.get("language") == "comment"
    ]
    return [f"# {line}".rstrip() for text in texts for line in text.splitlines()]


def _written(value: object) -> str:
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(_written, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value)
