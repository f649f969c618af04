"""Package metadata: the only place that names versions, dependencies and data files."""

from pathlib import Path

from setuptools import find_packages, setup

MQTT = ["paho-mqtt>=2,<3"]
ROS = ["rosbags>=0.10,<0.12", "mcap>=1.2,<2", "lz4>=4"]
SWEEP = ["distributed>=2024.8", "pyarrow>=16"]

setup(
    name="han_bullet",
    version="0.1.0",
    description="Human-aware navigation that sees people: cameras in, considerate robot motion out",
    long_description=Path(__file__).with_name("README.md").read_text(encoding="utf-8"),
    long_description_content_type="text/markdown",
    license="BSD-3-Clause",
    python_requires=">=3.10,<3.12",
    packages=[
        *find_packages(include=["han_bullet", "han_bullet.*", "ros1_bridge"]),
        "han_bullet.worlds",
        "han_bullet.urdf",
    ],
    package_dir={"han_bullet.worlds": "worlds", "han_bullet.urdf": "urdf"},
    package_data={
        "han_bullet": ["py.typed"],
        "han_bullet.models": ["*.npz", "*.safetensors", "*.md"],
        "ros1_bridge": ["package.xml", "CMakeLists.txt", "launch/*", "config/*", "rviz/*", "scripts/*"],
        "han_bullet.worlds": ["*.yaml"],
        "han_bullet.urdf": ["*.urdf", "meshes/*", "meshes/**/*", "textures/*"],
    },
    install_requires=[
        "numpy>=1.26",
        "scipy>=1.11",
        "numba>=0.60",
        "opencv-python-headless>=4.8,<5",
        "pybullet>=3.2.6",
        "torch>=2.2",
        "safetensors>=0.4",
        "filterpy>=1.4.5",
        "matplotlib>=3.8",
        "pillow>=10",
        "pydantic>=2.5",
        "PyYAML>=6",
        "rich>=13",
        "imageio-ffmpeg>=0.4.9",
    ],
    extras_require={
        "dev": [
            "pytest>=8",
            "hypothesis>=6",
            "ruff>=0.5",
            "mypy>=1.10",
            "types-PyYAML",
            "scikit-image>=0.22",
            "stonesoup>=1.9",
            "psutil>=5.9",
            *SWEEP,
            *MQTT,
            *ROS,
        ],
        "sweep": SWEEP,
        "mqtt": MQTT,
        "ros": ROS,
        "bench": ["pyastar2d>=1.1", "scikit-image>=0.22", "stonesoup>=1.9"],
    },
    entry_points={"console_scripts": ["han-bullet=han_bullet.cli:main"]},
)
