"""Links that open a manifest in the page that runs it; `book/src/use/analysis.md` describes them."""

import base64
import zlib

MOST_CHARACTERS = 8192


def play_link(manifest, page="../play.html"):
    """The address of a manifest in the play page, or `None` if it would be too long. `page` is relative to the page with the link; the default is that of
    `book/src/*.md`, and a page in a folder of the book needs one `../` more."""
    packed = base64.urlsafe_b64encode(zlib.compress(manifest.encode(), 9)).rstrip(b"=").decode()
    link = f"{page}#manifest={packed}"
    return link if len(link) <= MOST_CHARACTERS else None
