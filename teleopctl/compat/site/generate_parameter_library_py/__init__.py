"""``generate_parameter_library_py``. Parameters declared in YAML, as classes.

``from my_package.my_parameters import my_node`` works for each module that a package's ``setup.py``
or ``CMakeLists.txt`` makes with ``generate_parameter_module``: it is made when it is imported.
"""
