"""The contracts: what a backend, a transport and a check must and may implement."""
