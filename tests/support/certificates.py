"""Certificates for tests, made with the command openssl."""

import subprocess
from pathlib import Path

__all__ = ["Authority"]


class Authority:
    """Somebody who signs certificates."""

    def __init__(self, folder: Path, name: str) -> None:
        """Makes its own."""
        self._folder = folder
        self.file = folder / f"{name}.pem"
        self._key = folder / f"{name}.key"
        # From Python 3.13 on an authority must say what its key is for.
        usage = ("-addext", "keyUsage=critical,keyCertSign,cRLSign")
        _openssl(
            "req", "-x509", *_new_key(self._key, name), "-days", "2", *usage, "-out", str(self.file)
        )

    def sign(self, name: str, *, host: str = "", days: int = 2) -> tuple[Path, Path]:
        """A certificate and its key; with a negative number of days it has expired."""
        certificate, key = (self._folder / f"{name}.{ending}" for ending in ("pem", "key"))
        request, extensions = (self._folder / f"{name}.{ending}" for ending in ("csr", "ext"))
        extensions.write_text(f"subjectAltName = {host}\n" if host else "")
        _openssl("req", *_new_key(key, name), "-out", str(request))
        _openssl(
            "x509", "-req", "-in", str(request), "-CA", str(self.file), "-CAkey", str(self._key),
            "-CAcreateserial", "-days", str(days), "-extfile", str(extensions),
            "-out", str(certificate),
        )  # fmt: skip
        return certificate, key


def _new_key(file: Path, name: str) -> list[str]:
    curve = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1"]
    return [*curve, "-nodes", "-keyout", str(file), "-subj", f"/CN={name}"]


def _openssl(*arguments: str) -> None:
    subprocess.run(["openssl", *arguments], check=True, capture_output=True, timeout=20)
