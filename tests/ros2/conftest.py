import importlib
import warnings

with warnings.catch_warnings():
    # What ROS imports for its first message imports a deprecated module of Python.
    warnings.simplefilter("ignore", DeprecationWarning)
    try:
        importlib.import_module("rosidl_generator_py")
    except ImportError:
        pass  # the tests here are skipped without ROS
