from glob import glob

from setuptools import find_packages, setup

setup(
    name="bathbot_bringup",
    version="0.1.0",
    packages=find_packages(include=["bathbot_bringup*"]),
    package_data={"bathbot_bringup": ["sim/data/*.npz", "sim/data/scenarios/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/bathbot_bringup"]),
        ("share/bathbot_bringup", ["package.xml"]),
        ("share/bathbot_bringup/config", glob("config/*")),
        ("share/bathbot_bringup/launch", glob("launch/*.launch.py")),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    description="Launch files, simulated bathroom, recording, replay, reports and the bathbot command.",
    maintainer="The bathbot maintainers",
    maintainer_email="maintainers@bathbot.invalid",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "bathbot = bathbot_bringup.command.cli:main",
            "recorder = bathbot_bringup.bag.recording.recorder_node:main",
            "replayer = bathbot_bringup.bag.replaying.replayer_node:main",
            "sim_camera = bathbot_bringup.sim.camera.sim_camera_node:main",
            "sim_rm65 = bathbot_bringup.sim.arm.sim_rm65_node:main",
        ],
    },
)
