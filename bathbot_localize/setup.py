from glob import glob

from setuptools import find_packages, setup

setup(
    name="bathbot_localize",
    version="0.1.0",
    packages=find_packages(include=["bathbot_localize*"]),
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/bathbot_localize"]),
        ("share/bathbot_localize", ["package.xml"]),
        ("share/bathbot_localize/config", glob("config/*")),
        ("share/bathbot_localize/launch", glob("launch/*.launch.py")),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    description="Turns skin regions and depth into contact targets; hand-eye calibration.",
    maintainer="The bathbot maintainers",
    maintainer_email="maintainers@bathbot.invalid",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "target_localizer = bathbot_localize.target_localizer_node:main",
        ],
    },
)
