"""Who may hear the nodes and be heard by them: one word of the user, `BATHBOT_REACH`.

`user` (where nothing is said): programs of the same user on this machine. `machine`: of all its users.
`network`: whoever the network reaches and holds a key of SROS2; then ROS's own variables choose the way.
ROS's variables alone widen nothing, for they are set in many a shell start-up file.
"""

import os
from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path

from bathbot_depthcorr.errors import SettingsError

VARIABLE = "BATHBOT_REACH"
ENCLAVE = "ROS_SECURITY_ENCLAVE_OVERRIDE"
_KEYSTORE = "ROS_SECURITY_KEYSTORE"
_ENFORCED = {"ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": "Enforce"}
_RMW, _FASTDDS = "RMW_IMPLEMENTATION", "rmw_fastrtps_cpp"


class Reach(StrEnum):
    """How far the graph reaches."""

    USER = "user"
    MACHINE = "machine"
    NETWORK = "network"


def chosen(environment: Mapping[str, str] = os.environ) -> Reach:
    """What the environment asks for.

    Raises:
        SettingsError: When it is no reach, or one that cannot be kept to.
    """
    word = environment.get(VARIABLE, Reach.USER)
    if word not in tuple(Reach):
        raise SettingsError(
            f"{VARIABLE} is {word!r}; user hears programs of this user only (the default), machine those of "
            "all users here, network whoever has a key of SROS2"
        )
    reach = Reach(word)
    if reach is Reach.NETWORK:
        _check_keys(environment)
    elif (rmw := environment.get(_RMW) or _FASTDDS) != _FASTDDS:
        raise SettingsError(
            f"{_RMW} is {rmw!r}, which nobody has taught to keep to this machine; unset it, or have "
            f"{VARIABLE}=network with keys of SROS2"
        )
    return reach


def network_variables(keystore: Path, enclave: str) -> dict[str, str]:
    """The environment in which a holder of an enclave's key joins over the network."""
    return {VARIABLE: Reach.NETWORK.value, **_ENFORCED, _KEYSTORE: str(keystore), ENCLAVE: enclave}


def _check_keys(environment: Mapping[str, str]) -> None:
    wrong = [f"{name}={value}" for name, value in _ENFORCED.items() if environment.get(name) != value]
    keystore = environment.get(_KEYSTORE, "")
    if not (keystore and Path(keystore).is_dir()):
        wrong.append(f"{_KEYSTORE}=FOLDER with the keys, which `bathbot keys FOLDER` makes")
    if wrong:
        raise SettingsError(
            f"{VARIABLE}=network shows pictures of the person, and lets the arm be moved, to all that the "
            f"network reaches, so it needs SROS2; set also {' and '.join(wrong)}"
        )
    from bathbot_depthcorr.node.dds import enclave  # loads ssl, which nobody else needs

    name = environment.get(ENCLAVE) or "/"
    if trouble := enclave.trouble(Path(keystore), name):
        raise SettingsError(
            f"the enclave {name!r} of {_KEYSTORE}={keystore} cannot be used: {trouble}; set {ENCLAVE} to "
            "another, such as /bathbot/robot, or make new keys with `bathbot keys FOLDER`"
        )


def seen_by(reach: Reach) -> str:
    """Say to a person who sees pictures and moves the arm then."""
    return {
        Reach.USER: "programs of this user on this machine",
        Reach.MACHINE: "every user of this machine: pictures and the arm are open to all of them",
        Reach.NETWORK: "whoever the network reaches and holds a key: pictures and the arm are open to them",
    }[reach]
