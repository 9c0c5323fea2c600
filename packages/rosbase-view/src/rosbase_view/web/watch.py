"""A script in the page that tells when the view is gone, and loads the page again. Pure.

viser's client keeps what it showed last, says nothing, and does not find a view that was started
again. So the page asks for `alive` beside it, which is another word after each start.
"""

import gzip

from websockets.datastructures import Headers
from websockets.http11 import Response

__all__ = ["ALIVE", "with_watch"]

ALIVE = "/alive"
"""Path that the script asks for."""

_TEXT = "No connection to rosbase view. The page shows old data, and connects again by itself."
# A browser that draws without a graphics processor stands still for seconds, so the limit is wide.
_SCRIPT = f"""<script>(() => {{
  const address = location.pathname.replace(/[^/]*$/, "") + "{ALIVE[1:]}";
  const note = document.createElement("div");
  note.setAttribute("role", "alert");
  note.textContent = "{_TEXT}";
  note.style.cssText = "position: fixed; z-index: 99999; top: 0; left: 0; right: 0; padding: 0.6em;"
    + "background: #c92a2a; color: white; font: 16px sans-serif; text-align: center";
  let first = null;
  async function look() {{
    let word = null;
    try {{
      const limit = AbortSignal.timeout(20000);
      const answer = await fetch(address, {{cache: "no-store", signal: limit}});
      if (answer.ok) word = await answer.text();
    }} catch (_) {{}}
    if (word === null) document.body.append(note);
    else if (note.isConnected || (first !== null && word !== first)) return location.reload();
    first ??= word;
    setTimeout(look, 1000);
  }}
  look();
}})();</script>""".encode()
_END_OF_HEAD = b"</head>"


def with_watch(response: Response) -> Response:
    """Return a response with the script, if it is the page."""
    headers = response.headers
    if response.status_code != 200 or not headers.get("Content-Type", "").startswith("text/html"):
        return response
    is_packed = headers.get("Content-Encoding") == "gzip"
    page = gzip.decompress(response.body) if is_packed else bytes(response.body)
    page = page.replace(_END_OF_HEAD, _SCRIPT + _END_OF_HEAD, 1)
    body = gzip.compress(page) if is_packed else page
    kept = [(name, value) for name, value in headers.raw_items() if name != "Content-Length"]
    found = Headers([*kept, ("Content-Length", str(len(body)))])
    return Response(response.status_code, response.reason_phrase, found, body)
