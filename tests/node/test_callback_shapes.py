"""Which callables of a subscription are handed the message's information besides the message."""

import functools

import pytest

from teleopctl.node.endpoints.subscription import _takes_two


def nothing():
    pass


def one(message):
    pass


def two(message, info):
    pass


def three(message, info, more):
    pass


def optional_second(message, info=None):
    pass


def optional_third(message, info, more=None):
    pass


def anything(*arguments):
    pass


def one_and_anything(message, *rest):
    pass


def two_and_anything(message, info, *rest):
    pass


def optional_keyword(message, *, keyword=None):
    pass


def required_keyword(message, *, keyword):
    pass


def keywords_only(**keywords):
    pass


@functools.wraps(one)
def wrapper_of_one(*arguments):
    return one(*arguments)


async def coroutine_of_two(message, info):
    pass


class Receiver:
    def __call__(self, message):
        pass

    def one(self, message):
        pass

    def two(self, message, info):
        pass

    def optional_second(self, message, info=None):
        pass

    def anything(self, *arguments):
        pass

    @classmethod
    def of_class(cls, message, info):
        pass

    @staticmethod
    def static(message):
        pass


class CalledWithTwo:
    def __call__(self, message, info):
        pass


@pytest.mark.parametrize(
    ("callback", "takes_two"),
    [
        pytest.param(one, False, id="one"),
        pytest.param(two, True, id="two"),
        pytest.param(optional_second, False, id="optional second"),
        pytest.param(optional_third, True, id="optional third"),
        pytest.param(anything, False, id="anything"),
        pytest.param(one_and_anything, False, id="one and anything"),
        pytest.param(two_and_anything, True, id="two and anything"),
        pytest.param(optional_keyword, False, id="optional keyword"),
        pytest.param(wrapper_of_one, False, id="wrapper"),
        pytest.param(coroutine_of_two, True, id="coroutine function"),
        pytest.param(lambda message: None, False, id="lambda of one"),
        pytest.param(lambda message, info: None, True, id="lambda of two"),
        pytest.param(lambda message, self=None: None, False, id="lambda that keeps a value"),
        pytest.param(Receiver().one, False, id="method of one"),
        pytest.param(Receiver().two, True, id="method of two"),
        pytest.param(Receiver().optional_second, False, id="method with optional second"),
        pytest.param(Receiver().anything, False, id="method of anything"),
        pytest.param(Receiver.of_class, True, id="class method"),
        pytest.param(Receiver.static, False, id="static method"),
        pytest.param(Receiver(), False, id="object called with one"),
        pytest.param(CalledWithTwo(), True, id="object called with two"),
        pytest.param(functools.partial(one), False, id="partial of one"),
        pytest.param(functools.partial(two), True, id="partial of two"),
        pytest.param(functools.partial(two, "bound"), False, id="partial with one bound"),
        pytest.param(functools.partial(three, "bound"), True, id="partial with two left"),
        pytest.param(functools.partial(two, info=0), False, id="partial with a keyword bound"),
        pytest.param(functools.partial(Receiver().two, "bound"), False, id="partial of a method"),
        pytest.param([].append, False, id="built-in method"),
        pytest.param(print, False, id="built-in function"),
        pytest.param(str.join, True, id="method of a built-in class"),
    ],
)
def test_the_shape_of_a_callback_tells_what_it_gets(callback, takes_two):
    assert _takes_two(callback) is takes_two


@pytest.mark.parametrize(
    "callback",
    [nothing, three, required_keyword, keywords_only, functools.partial(one, "bound")],
    ids=lambda callback: getattr(callback, "__name__", "partial"),
)
def test_a_callback_that_takes_neither_one_nor_two_is_refused(callback):
    with pytest.raises(RuntimeError, match="one argument"):
        _takes_two(callback)
