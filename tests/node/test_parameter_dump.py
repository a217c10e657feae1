"""What is dumped of parameters is what a parameter file holds."""

from hypothesis import given, strategies as st

from teleopctl.base import ros_yaml
from teleopctl.interfaces import parameter_value_to_python
from teleopctl.node.values.parameter import Parameter
from teleopctl.node.values.parameter_file import parameter_document, read_parameter_file

TEXTS = st.text(st.characters(exclude_categories=("Cs", "Cc")))
INTEGERS = st.integers(-(2**63), 2**63 - 1)
DOUBLES = st.floats(allow_nan=False)
VALUES = st.one_of(
    *(st.booleans(), INTEGERS, DOUBLES, TEXTS),
    *(st.lists(each, min_size=1, max_size=3) for each in (st.booleans(), INTEGERS, DOUBLES, TEXTS)),
    st.lists(st.binary(min_size=1, max_size=1), min_size=1, max_size=3),
)


@given(VALUES)
def test_a_parameter_file_gives_back_what_was_dumped(tmp_path_factory, value):
    name = "limits.first"
    message = Parameter(name, value=value).get_parameter_value()
    file = tmp_path_factory.getbasetemp() / "dumped.yaml"
    document = parameter_document("/node", [(name, message)])
    file.write_text(ros_yaml.dump(document), encoding="utf-8")
    again = Parameter(name, value=read_parameter_file(file).for_node("/node")[name])
    assert again.get_parameter_value() == message
    assert parameter_value_to_python(again.get_parameter_value()) == value
