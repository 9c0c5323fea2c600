"""Parse TOML. Python has a parser from 3.11 on; on 3.10, tomli provides the same one."""

import sys

if sys.version_info >= (3, 11):
    from tomllib import loads as parse_toml
else:
    from tomli import loads as parse_toml

__all__ = ["parse_toml"]
