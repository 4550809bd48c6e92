# make demo   the whole bathing job in the simulated bathroom
# make test   all tests: first those of this process alone, on all cores, then those that start others
# make colcon builds and tests the same tree with colcon against the ROS wheels
# make setup  only install; both of the above do it when something is missing

# Whichever of these is a Python 3.12 (pyenv and uv make one of them so through .python-version).
PYTHON ?= $(firstword $(foreach name,python3.12 python3 python,\
  $(shell $(name) -c 'import sys; sys.version_info[:2] == (3, 12) and print("$(name)")' 2>/dev/null)))
VENV := .venv
SIZE := about 3 GB
BIN := $(VENV)/bin
PACKAGES := $(wildcard bathbot_*)
INTERFACES := $(shell find bathbot_msgs -type f)

# The same pins for the build environments: pip before 25.3 reads the first name, later ones the second.
export PIP_CONSTRAINT := $(CURDIR)/constraints.txt
export PIP_BUILD_CONSTRAINT := $(CURDIR)/constraints.txt
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.PHONY: demo test setup colcon clean

demo: setup
	$(BIN)/bathbot demo

test: setup
	$(BIN)/python -m pytest -m "not graph"
	$(BIN)/python -m pytest -m graph

setup: $(VENV)/system $(VENV)/interfaces $(VENV)/packages
	@:

# Each step says what it does; pip's own lines follow. A step that fails names the log that holds all of it.
SAY = printf '\n[%s of 4] %s\n'
FAILED = { echo "make: step $(1) of 4 failed; $(2)" >&2; exit 2; }

$(BIN)/python:
	@test -n "$(PYTHON)" || { echo "make: no Python 3.12 found; install it, or say where: make PYTHON=/path/to/python3.12" >&2; exit 2; }
	@$(SAY) 1 "a Python environment in $(VENV)"
	@$(PYTHON) -m venv $(VENV) || $(call FAILED,1,see the lines above)

# open3d loads libraries that a bare machine lacks: install them, or say how.
APT_LIBRARIES := libusb-1.0-0 libgl1 libgomp1 libx11-6
$(VENV)/system: Makefile | $(BIN)/python
	@$(SAY) 2 "system libraries that open3d loads"
	@for library in libusb-1.0.so.0 libGL.so.1 libgomp.so.1 libX11.so.6; do \
	  $(BIN)/python -c "import ctypes; ctypes.CDLL('$$library')" 2>/dev/null || missing="$$missing $$library"; \
	done; \
	if [ -z "$$missing" ]; then echo "all there"; else \
	  if [ "$$(id -u)" = 0 ]; then as=""; else as="sudo -n"; fi; \
	  echo "installing what holds$$missing, with apt"; \
	  { $$as apt-get install -y -q $(APT_LIBRARIES) || { $$as apt-get update -q && $$as apt-get install -y -q $(APT_LIBRARIES); }; } > $(VENV)/apt.log 2>&1 || \
	  { echo "make: step 2 of 4 failed: missing$$missing; run: sudo apt-get install $(APT_LIBRARIES); the log is $(VENV)/apt.log" >&2; exit 2; }; \
	fi
	@touch $@

# Compiled from the ROS wheels, so only when an interface changed.
$(VENV)/interfaces: $(INTERFACES) constraints.txt | $(BIN)/python
	@$(SAY) 3 "the ROS interfaces, compiled here: one to two minutes; log: $(VENV)/interfaces.log"
	@rm -f $(VENV)/interfaces.log
	@$(BIN)/python -m pip install --log $(VENV)/interfaces.log ./bathbot_msgs || $(call FAILED,3,its log is $(VENV)/interfaces.log)
	@touch $@

$(VENV)/packages: pyproject.toml constraints.txt $(VENV)/interfaces
	@$(SAY) 4 "bathbot and the packages it needs: 1 to 3 minutes, $(SIZE) in $(VENV); log: $(VENV)/packages.log"
	@rm -f $(VENV)/packages.log
	@$(BIN)/python -m pip install --log $(VENV)/packages.log --editable '.[test,colcon]' || $(call FAILED,4,its log is $(VENV)/packages.log)
	@touch $@
	@printf '\nset up; see: $(BIN)/bathbot --help\n'

# On Ubuntu with apt's ROS 2 plain `colcon build` does the same.
colcon: export AMENT_PREFIX_PATH := $(CURDIR)/$(VENV)
colcon: export CMAKE_PREFIX_PATH := $(CURDIR)/$(VENV)
colcon: export ROS_DISTRO := jazzy
colcon: export ROS_VERSION := 2
colcon: export ROS_PYTHON_VERSION := 3
colcon: export PATH := $(CURDIR)/$(BIN):$(PATH)
colcon: setup
	colcon build --merge-install --cmake-args -DBUILD_TESTING=OFF -DCMAKE_PROJECT_INCLUDE=$(CURDIR)/bathbot_msgs/pip/ros_wheels.cmake -DPython3_EXECUTABLE=$(CURDIR)/$(BIN)/python
	colcon test --merge-install --event-handlers console_cohesion+
	colcon test-result

clean:
	rm -rf $(VENV) build install log
