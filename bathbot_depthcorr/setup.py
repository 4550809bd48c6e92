from glob import glob

from setuptools import find_packages, setup

setup(
    name="bathbot_depthcorr",
    version="0.1.0",
    packages=find_packages(include=["bathbot_depthcorr*"]),
    package_data={"bathbot_depthcorr": ["node/dds/*.xml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/bathbot_depthcorr"]),
        ("share/bathbot_depthcorr", ["package.xml"]),
        ("share/bathbot_depthcorr/config", glob("config/*")),
        ("share/bathbot_depthcorr/launch", glob("launch/*.launch.py")),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    description="Corrects the depth of an RGB-D camera: per pixel, then globally.",
    maintainer="The bathbot maintainers",
    maintainer_email="maintainers@bathbot.invalid",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "depth_corrector = bathbot_depthcorr.live.depth_corrector_node:main",
        ],
    },
)
