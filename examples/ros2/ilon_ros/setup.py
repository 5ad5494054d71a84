from glob import glob

from setuptools import setup

SHARE = "share/ilon_ros"

setup(
    name="ilon_ros",
    version="0.1.0",
    packages=["ilon_ros"],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/ilon_ros"]),
        (SHARE, ["package.xml"]),
        (f"{SHARE}/launch", glob("launch/*.launch.py")),
        (f"{SHARE}/config", glob("config/*.yaml")),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    maintainer="The ilon developers",
    maintainer_email="ilon@example.org",
    description="Launch files for ilon: teleoperation, ros2_control, Nav2",
    license="MIT OR Apache-2.0",
)
