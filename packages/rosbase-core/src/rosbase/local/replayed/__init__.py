"""The backend of a replay whose program ran on a middleware, which the replay does not need.

All that came to the program comes from the recording. What it publishes reaches taps, and nobody
else. It notes nothing by itself: `contracts/recorded_answers` says what the backend of the
middleware has noted, and this one asks for it in the same order.
"""
