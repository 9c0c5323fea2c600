"""Look at running programs of this user, and operate them, over a Unix socket.

`programs` and `server` are the side of the program, `client` and `fleet` the other one; `folder`
and `frames` are shared.
"""
