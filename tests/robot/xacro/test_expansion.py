"""A xacro file is expanded, or one error says where and why not."""

import logging

import pytest

from teleopctl.errors import InvalidDescriptionError, TeleopctlError
from teleopctl.packages import package_share
from teleopctl.robot.xacro.expansion import expand_xacro, read_xacro
from tests.packages.prefix import install
from tests.samples import sample

NAMESPACE = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'


@pytest.fixture
def write(tmp_path):
    def write(body, name="robot.xacro", head=f'<robot name="r" {NAMESPACE}>'):
        path = tmp_path / name
        path.write_text(f"{head}\n{body}\n</robot>")
        return path

    return write


def failure(path, **mappings):
    with pytest.raises(TeleopctlError) as caught:
        expand_xacro(path, mappings)
    return caught.value


def test_arguments_replace_defaults(write):
    path = write('<xacro:arg name="size" default="1"/><link name="l$(arg size)"/>')
    assert '<link name="l1"/>' in expand_xacro(path)
    assert '<link name="l7"/>' in expand_xacro(path, {"size": "7"})


def test_the_callers_mapping_is_left_alone(write):
    mappings = {"a": "1"}
    expand_xacro(write('<xacro:arg name="b" default="2"/>'), mappings)
    assert mappings == {"a": "1"}


def test_plain_urdf_passes(write):
    assert "<link" in expand_xacro(write('<link name="a"/>', "plain.urdf", '<robot name="r">'))


def test_find_resolves_packages(write):
    path = write('<link name="$(find teleop_description)"/>')
    assert "teleop_description" not in expand_xacro(path)


def test_find_of_an_unknown_package_says_where_packages_are_looked_for(write):
    path = write('<link name="$(find no_such_package)"/>')
    assert failure(path).message == f"{path}: Package 'no_such_package' not found"
    assert "Packages are searched in $TELEOPCTL_PACKAGE_PATH" in (failure(path).hint or "")


def test_find_resolves_what_a_sourced_ros_has_installed(write, tmp_path, monkeypatch):
    install(tmp_path / "prefix", "known")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "prefix"))
    share = tmp_path / "prefix/share/known"
    assert f'"{share}"' in expand_xacro(write('<link name="$(find known)"/>'))


def test_a_missing_file_is_named(tmp_path):
    error = failure(tmp_path / "none.xacro")
    assert error.message == f"Cannot read {tmp_path / 'none.xacro'}: No such file or directory"


def test_broken_xml_is_named_with_its_line(write):
    path = write("<link>")
    assert failure(path).message == f"{path}:3:3: invalid XML: mismatched tag"


def test_a_missing_namespace_is_explained(write):
    error = failure(write("<xacro:foo/>", head='<robot name="r">'))
    assert "unbound prefix" in error.message
    assert NAMESPACE in error.hint


def test_an_unknown_name_is_reported_with_its_line(write):
    path = write('<link name="a"/>\n<link name="${width * 2}"/>')
    message = failure(path).message
    assert message.startswith(f"{path}:3: ")
    assert "name 'width' is not defined" in message


def test_an_error_in_a_macro_names_the_macro_and_its_file(write):
    parts = write(
        '<xacro:macro name="part" params="n"><link name="${1 / n}"/></xacro:macro>', "parts.xacro"
    )
    path = write('<xacro:include filename="parts.xacro"/><xacro:part n="0"/>')
    message = failure(path).message
    assert message.startswith(f"{parts}:2: division by zero")
    assert message.endswith("(in macro part)")


def test_a_missing_include_is_named(write):
    path = write('<xacro:include filename="none.xacro"/>')
    message = failure(path).message
    assert str(path) in message
    assert "none.xacro: No such file or directory" in message


def test_broken_xml_in_an_include_names_the_include(write, tmp_path):
    (tmp_path / "part.xacro").write_text("<robot>")
    path = write('<xacro:include filename="part.xacro"/>')
    assert f"{tmp_path / 'part.xacro'}:1:8: invalid XML: no element found" in failure(path).message


def test_an_unknown_package_is_named(write):
    path = write('<xacro:include filename="$(find no_such_package)/x.xacro"/>')
    assert failure(path).message == f"{path}: Package 'no_such_package' not found"


def test_files_that_include_each_other_without_end_are_reported(write):
    path = write('<xacro:include filename="robot.xacro"/>')
    assert "without end" in failure(path).message


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ("<xacro:wheel/>", "unknown macro name: xacro:wheel"),
        ('<link name="$(arg none)"/>', "Undefined substitution argument none"),
        ('<link name="${1+"/>', "invalid expression"),
        ("${xacro.fatal('not like this')}", "not like this"),
        ('<link name="$(env NO_SUCH_VARIABLE_HERE)"/>', "environment variable"),
    ],
)
def test_the_reason_is_told(write, body, reason):
    assert reason in failure(write(body)).message


def test_nothing_is_printed_and_warnings_are_logged(write, capfd, caplog):
    with caplog.at_level(logging.WARNING):
        expand_xacro(write("${xacro.warning('old part')}"))
    failure(write("<xacro:wheel/>"))
    assert capfd.readouterr() == ("", "")
    assert "old part" in caplog.text


def test_one_failure_does_not_spoil_the_next_expansion(write):
    good = write('<link name="a"/>', "good.xacro")
    failure(write('<xacro:macro name="m"><xacro:none/></xacro:macro><xacro:m/>'))
    assert "<link" in expand_xacro(good)


SAFE = """
<xacro:arg name="long" default="true"/>
<xacro:property name="length" value="2"/>
<xacro:property name="half" value="${length / 2}"/>
<xacro:macro name="rod" params="name size:=1"><link name="${name}_${int(size)}"/></xacro:macro>
<xacro:if value="$(arg long)"><xacro:rod name="a" size="${half + math.cos(0)}"/></xacro:if>
<xacro:unless value="${length &gt; 1}"><xacro:rod name="b"/></xacro:unless>
"""


def test_safe_mode_computes_what_most_descriptions_need(write):
    path = write(SAFE)
    assert '<link name="a_2"/>' in expand_xacro(path, safe=True)
    assert expand_xacro(path, safe=True) == expand_xacro(path)


def test_the_teleop_arm_is_the_same_in_safe_mode():
    path = package_share("teleop_description") / "urdf" / "teleop.urdf.xacro"
    assert expand_xacro(path, safe=True) == expand_xacro(path)


@pytest.mark.parametrize(
    "text",
    [
        "${xacro.load_yaml('/etc/passwd')}",
        "${load_yaml('/etc/passwd')}",
        "${[x for x in [1]]}",
        "${'%s' % math}",
        "${str.format('{0.__class__}', 1)}",
        "${python.vars()}",
        "${math}",
        "${xacro.error('x')}",
        "$(eval 1 + 1)",
        "$(env HOME)",
        "$(optenv HOME x)",
    ],
)
def test_safe_mode_refuses_everything_else_and_leaves_xacro_as_it_was(write, text, monkeypatch):
    path = write(f'<link name="{text}"/>')
    monkeypatch.setenv("TELEOPCTL_SAFE", "1")
    with pytest.raises(InvalidDescriptionError, match="refused in safe mode") as refused:
        expand_xacro(path)
    assert str(path) in refused.value.message
    monkeypatch.setenv("TELEOPCTL_SAFE", "0")
    assert "built-in function" in expand_xacro(write('<link name="${math.sin}"/>'))


def test_the_files_that_are_included_are_told_each_time_anew(tmp_path):
    xacro = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
    (tmp_path / "values.yaml").write_text("a: 1")
    inner, outer = tmp_path / "inner.xacro", tmp_path / "outer.xacro"
    inner.write_text(f"<robot {xacro}><link name='a'/></robot>")
    include = '<xacro:include filename="inner.xacro"/>'
    values = '<xacro:property name="v" value="${xacro.load_yaml(\'values.yaml\')}"/>'
    outer.write_text(
        f"<robot {xacro}>{include}{values}<link name='${{v[&quot;a&quot;]}}'/></robot>"
    )
    assert set(read_xacro(outer).files) == {outer, inner, tmp_path / "values.yaml"}
    assert read_xacro(inner).files == (inner,)
    assert read_xacro(outer).text == expand_xacro(outer)


@pytest.mark.parametrize("safe", [False, True])
def test_a_file_that_doubles_itself_is_refused(write, monkeypatch, safe):
    monkeypatch.setattr("teleopctl.base.budget.MOST_MACRO_CALLS", 1000)
    twice = "".join(
        f'<xacro:macro name="m{n}"><xacro:m{n + 1}/><xacro:m{n + 1}/></xacro:macro>'
        for n in range(60)
    )
    macros = write(f'{twice}<xacro:macro name="m60"><link name="l"/></xacro:macro><xacro:m0/>')
    with pytest.raises(InvalidDescriptionError, match="more than 1,000 calls of macros"):
        expand_xacro(macros, safe=safe)
    texts = "".join(
        f'<xacro:property name="t{n}" value="${{t{n - 1}}}${{t{n - 1}}}"/>' for n in range(1, 60)
    )
    text = write(f'<xacro:property name="t0" value="lol"/>{texts}<link name="${{t59}}"/>')
    with pytest.raises(InvalidDescriptionError, match="a text has more than 1,000,000 characters"):
        expand_xacro(text, safe=safe)
    assert "<link" in expand_xacro(
        write('<xacro:macro name="m"><link name="l"/></xacro:macro><xacro:m/>')
    )


@pytest.mark.parametrize(
    "text",
    sample(
        [
            "${9**9**9**9}",
            "$(eval 9**9**9**9)",
            "${1 &lt;&lt; 10**12}",
            "${math.factorial(10**8)}",
            "${len(list(range(10**12)))}",
            "${python.sum(python.range(10**11))}",
            "${python.sum(map(lambda x: python.sum(python.range(x)), [10**12]))}",
            "${len([x for x in range(10**6) for y in range(10**6)])}",
            "${'a' * 10**11}",
            "${[0] * 10**11}",
            "${10**11 * (0,)}",
            "${'a'.ljust(10**11)}",
            "${'%100000000000d' % 1}",
            "${wide.format(1)}",
            "${nested.format(1, 10**11)}",
            "$(eval f'{1:100000000000}')",
            "${('a' * 10**6).replace('a', 'b' * 10**6)}",
            "${('a' * 10**6).join(str(x) for x in range(10**6))}",
            "${(lambda f: f(f, 100))(lambda f, n: f(f, n - 1) + f(f, n - 1) if n else 1)}",
            "${(lambda f: f(f))(lambda f: f(f))}",
            "${math.prod(python.range(1, 10**5))}",
            "${math.lcm(*python.range(1, 10**5))}",
            "${len(python.sum([[0]] * 10**5, []))}",
            "${len(str([9**3000] * 10**5))}",
            "${(lambda f: f(f, 'ab', 60))(lambda f, x, n: f(f, x + x, n - 1) if n else x)}",
        ],
        3,
    ),
)
def test_an_expression_without_end_is_an_error_with_its_place(write, text, monkeypatch):
    monkeypatch.setattr("teleopctl.base.budget.MOST_OPERATIONS", 100_000)
    wide = '<xacro:property name="wide" value="{:100000000000}"/>'
    nested = '<xacro:property name="nested" value="{:{}}"/>'
    message = failure(write(f'{wide}{nested}\n<link name="{text}"/>')).message
    assert (
        "more than" in message
        or "takes no number beyond" in message
        or "a width" in message
        or "recurses" in message
    )
    assert "robot.xacro:3: " in message


def test_lists_of_lists_that_nobody_could_write_down_are_refused(write):
    nested = "".join(
        f'<xacro:property name="t{n}" value="${{[t{n - 1}, t{n - 1}]}}"/>' for n in range(1, 60)
    )
    path = write(f'<xacro:property name="t0" value="lol"/>{nested}<link name="${{t59}}"/>')
    with pytest.raises(InvalidDescriptionError, match="more than 1,000,000 parts"):
        expand_xacro(path)


PYTHON = {
    "2 ** 3 ** 2 % 7 + (1 &lt;&lt; 4)": "17",
    "-0.5 ** 2": "-0.25",
    "'ab' * 2 + '%.2f' % pi": "abab3.14",
    "[x * y for x in range(4) if x for y in [10, 20]][-1]": "60",
    "(lambda n: n + 1)(n=2)": "3",
    "max(*[1, 7, 3])": "7",
    "', '.join(sorted(dict(b=1, a=2)))": "a, b",
    "dict((k, v) for k, v in zip('ab', [1, 2]))['b']": "2",
    "10 ** 12": "1000000000000",
    "math.prod([2, 3.5], start=2) + math.lcm(4, 6)": "26.0",
    "python.sum([1, 2], 3) + python.sum([1, 2], start=4)": "13",
    "len(python.sum([[1], [2, 3]], []))": "3",
    "max(10000000.0, 20000000)": "20000000",
    "'a b'.replace(' ', '_').ljust(5, '-')": "a_b--",
}


@pytest.mark.parametrize("text", PYTHON)
def test_what_expressions_mean_is_python(write, text):
    text_of = f'<link name="${{{text}}}"/>'.replace("sorted(", "python.sorted(")
    path = write(text_of.replace("zip(", "python.zip(").replace("range(", "python.range("))
    assert f'<link name="{PYTHON[text]}"/>' in expand_xacro(path)


def test_the_bounds_are_gone_after_an_expansion(write):
    import xacro
    from xacro import substitution_args

    assert '"    3.14|x"' in expand_xacro(write("""<link name="$(eval f'{3.14:>8}|x')"/>"""))
    before = vars(xacro)["safe_eval"]
    failure(write("${9**9**9**9}"))
    assert vars(xacro)["safe_eval"] is before
    assert "eval" not in vars(substitution_args)
    assert "<link" in expand_xacro(write('<link name="$(eval 1 + 1)"/>'))
