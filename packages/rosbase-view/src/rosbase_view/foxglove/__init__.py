"""The server for Foxglove, Lichtblick and PlotJuggler, on foxglove-sdk.

`names`, `wanted`, `values`, `transforms` and `graph` are pure. `server` is the server of the SDK,
and `listener` takes what its clients ask for. `channels`, `parameter_desk`, `service_desk` and
`client_topics` each bring one subject from the running programs to the server, and back;
`live_bridge` runs them.
"""
