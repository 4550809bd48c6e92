"""A keystore of SROS2, laid out as `ros2 security create_keystore` and `create_enclave` lay it out.

public/ private/        certificate and key of the authority that signs all else
enclaves/governance.*   what holds for everybody
enclaves/<name>/        certificate, key and permissions of one enclave, and links to what holds for everybody
"""

import os
import shutil
import tempfile
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import NamedTuple

from bathbot_depthcorr.node.dds.ros_words import DOMAINS
from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat, pkcs7
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from bathbot_bringup.errors import InputError, SettingsError
from bathbot_bringup.graph.keys.rights import Enclave, governance, permissions

DAYS = range(1, 3651)
_SLOW_CLOCKS = timedelta(days=1)  # keys begin so much earlier, for machines whose clock is behind
_ROLES = ("identity_ca", "permissions_ca")


class Keystore(NamedTuple):
    """A keystore that was made.

    Attributes:
        folder: Where it lies, absolute.
        end: When all its keys end, UTC.
    """

    folder: Path
    end: datetime


class _Signer(NamedTuple):
    certificate: x509.Certificate
    key: ec.EllipticCurvePrivateKey

    def signed(self, text: str) -> bytes:
        """S/MIME with the text readable in front, as `openssl smime -sign -text` makes it."""
        builder = pkcs7.PKCS7SignatureBuilder().set_data(text.encode())
        options = [pkcs7.PKCS7Options.Text, pkcs7.PKCS7Options.DetachedSignature]
        return builder.add_signer(self.certificate, self.key, hashes.SHA256()).sign(Encoding.SMIME, options)


def make_keystore(
    folder: Path, enclaves: Sequence[Enclave], domains: Sequence[int], days: int, now: datetime | None = None
) -> Keystore:
    """Make new keys for all enclaves, the whole keystore or nothing of it.

    Args:
        folder: Does not exist, or is empty.
        enclaves: Who gets a key.
        domains: DDS domains that the keys are for.
        days: From now until the keys end.
        now: UTC; None: the clock's.

    Raises:
        SettingsError: When there is no such domain or time.
        InputError: When the folder is something else already.
        OSError: When it cannot be written.
    """
    if not domains or not set(domains) <= set(DOMAINS):
        raise SettingsError(f"domains must lie in 0..{DOMAINS[-1]}, one or more, got {list(domains)}")
    if days not in DAYS:
        raise SettingsError(f"days must lie in {DAYS[0]}..{DAYS[-1]}, got {days}")
    folder = folder.absolute()
    if folder.is_symlink() or (folder.exists() and not (folder.is_dir() and not any(folder.iterdir()))):
        raise InputError(f"{folder} is there already and not an empty folder; name a new one for the keys")
    begin = (now or datetime.now(UTC)).replace(microsecond=0)
    end = begin + timedelta(days=days)
    folder.parent.mkdir(parents=True, exist_ok=True)
    aside = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.parent))  # mode 0700
    try:
        _fill(aside, enclaves, sorted(set(domains)), begin - _SLOW_CLOCKS, end)
        aside.rename(folder)  # refused if somebody has put something there meanwhile
    finally:
        shutil.rmtree(aside, ignore_errors=True)
    return Keystore(folder, end)


def _fill(
    store: Path, enclaves: Sequence[Enclave], domains: Sequence[int], begin: datetime, end: datetime
) -> None:
    authority = _certified("bathbotCA", None, begin, end)
    _write_pair(authority, store / "public" / "ca.cert.pem", store / "private" / "ca.key.pem")
    for role in _ROLES:
        (store / "public" / f"{role}.cert.pem").symlink_to("ca.cert.pem")
        (store / "private" / f"{role}.key.pem").symlink_to("ca.key.pem")
    _write_signed(authority, governance(domains), store / "enclaves" / "governance.xml")
    for enclave in enclaves:
        home = store / "enclaves" / enclave.name.strip("/")
        _write_pair(_certified(enclave.name, authority, begin, end), home / "cert.pem", home / "key.pem")
        _write_signed(authority, permissions(enclave, domains, begin, end), home / "permissions.xml")
        for shared in (*(store / "public" / f"{role}.cert.pem" for role in _ROLES),
                       store / "enclaves" / "governance.p7s"):  # fmt: skip
            (home / shared.name).symlink_to(os.path.relpath(shared, home))


def _certified(name: str, authority: _Signer | None, begin: datetime, end: datetime) -> _Signer:
    """A new key with its certificate; signed by itself where there is no authority yet.

    The certificate of an enclave says what it is for: without that, its holder could sign permissions for
    himself, which OpenSSL would believe as they come from a key that the authority has signed.
    """
    key = ec.generate_private_key(ec.SECP256R1())
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
    builder = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(authority.certificate.subject if authority else subject)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(begin)
        .not_valid_after(end)
        .add_extension(x509.BasicConstraints(not authority, None if authority else 0), critical=True)
    )
    if authority:
        uses = [ExtendedKeyUsageOID.CLIENT_AUTH, ExtendedKeyUsageOID.SERVER_AUTH]
        builder = builder.add_extension(x509.ExtendedKeyUsage(uses), critical=False)
    return _Signer(builder.sign(authority.key if authority else key, hashes.SHA256()), key)


def _write_pair(pair: _Signer, certificate: Path, key: Path) -> None:
    _write(certificate, pair.certificate.public_bytes(Encoding.PEM))
    _write(key, pair.key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()))


def _write_signed(authority: _Signer, text: str, file: Path) -> None:
    _write(file, text.encode())
    _write(file.with_suffix(".p7s"), authority.signed(text))


def _write(file: Path, content: bytes) -> None:
    """Write a file that is this user's only, in folders that are."""
    for folder in reversed([one for one in file.parents if not one.exists()]):
        folder.mkdir(mode=0o700)
    with open(file, "xb", opener=lambda path, flags: os.open(path, flags, 0o600)) as opened:
        opened.write(content)
