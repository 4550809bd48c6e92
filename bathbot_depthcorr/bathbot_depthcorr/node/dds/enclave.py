"""Whether the keys of an enclave of SROS2 can be used, before DDS tries, which says so in many lines.

The key proves itself in a handshake with the authority's certificate, in memory: so it fits its
certificate, the authority has signed that, and neither has ended. What the signed permissions say, and
whether the signature holds, only DDS judges.
"""

import ssl
from pathlib import Path

AUTHORITY, CERTIFICATE, KEY = "identity_ca.cert.pem", "cert.pem", "key.pem"
FILES = (AUTHORITY, CERTIFICATE, KEY, "permissions_ca.cert.pem", "governance.p7s", "permissions.p7s")


def trouble(keystore: Path, name: str) -> str:
    """What is wrong with the enclave of this name; empty when nothing is."""
    folder = keystore / "enclaves" / name.strip("/")
    if missing := [file for file in FILES if not (folder / file).is_file()]:
        return f"it lacks {', '.join(missing)}"
    try:
        _shake_hands(folder)
    except ssl.SSLCertVerificationError as error:
        return f"{CERTIFICATE}: {error.verify_message}"
    except ssl.SSLError as error:
        return f"{KEY}, {CERTIFICATE} and {AUTHORITY} do not fit together ({error.reason or error})"
    except OSError as error:
        return f"{error.strerror}: {error.filename or folder}"
    return ""


def _shake_hands(folder: Path) -> None:
    """Let the holder of the key answer somebody who believes the authority; raises where he does not."""
    holder, other = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER), ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    holder.load_cert_chain(folder / CERTIFICATE, folder / KEY, password="")  # an encrypted one would ask
    other.check_hostname = False
    other.load_verify_locations(folder / AUTHORITY)
    to_holder, to_other = ssl.MemoryBIO(), ssl.MemoryBIO()
    ends = other.wrap_bio(to_other, to_holder), holder.wrap_bio(to_holder, to_other, server_side=True)
    for end in (*ends, ends[0]):
        try:
            end.do_handshake()
        except ssl.SSLWantReadError:
            continue  # until the other end has spoken
    if ends[0].version() is None:
        raise ssl.SSLError("the handshake did not end")
