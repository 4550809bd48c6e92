from glob import glob

from setuptools import find_packages, setup

setup(
    name="bathbot_perception",
    version="0.1.0",
    packages=find_packages(include=["bathbot_perception*"]),
    package_data={"bathbot_perception": ["models/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/bathbot_perception"]),
        ("share/bathbot_perception", ["package.xml"]),
        ("share/bathbot_perception/config", glob("config/*")),
        ("share/bathbot_perception/launch", glob("launch/*.launch.py")),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    description="Finds regions of bare skin in colour pictures with YOLOv5s in ONNX Runtime.",
    maintainer="The bathbot maintainers",
    maintainer_email="maintainers@bathbot.invalid",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "skin_detector = bathbot_perception.skin_detector_node:main",
        ],
    },
)
