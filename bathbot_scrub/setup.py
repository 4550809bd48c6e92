from glob import glob

from setuptools import find_packages, setup

setup(
    name="bathbot_scrub",
    version="0.1.0",
    packages=find_packages(include=["bathbot_scrub*"]),
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/bathbot_scrub"]),
        ("share/bathbot_scrub", ["package.xml"]),
        ("share/bathbot_scrub/config", glob("config/*")),
        ("share/bathbot_scrub/launch", glob("launch/*.launch.py")),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    description="Plans scrub paths on skin and drives the RM65-6F arm along them.",
    maintainer="The bathbot maintainers",
    maintainer_email="maintainers@bathbot.invalid",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "scrub_planner = bathbot_scrub.scrub_planner_node:main",
            "rm65_driver = bathbot_scrub.rm65.ros.rm65_driver_node:main",
        ],
    },
)
