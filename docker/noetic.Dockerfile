# corrsel in ROS Noetic on Ubuntu 20.04. Run in the folder of the package:
#   docker build -f docker/noetic.Dockerfile -t corrsel .                      # builds, installs into /opt/corrsel
#   docker build -f docker/noetic.Dockerfile --target test -t corrsel-test .   # also runs all tests
#   docker run --rm -it corrsel rosrun corrsel benchmark --list
#
# This image itself has not been built, because its package archives could not be reached where it was written.
# scripts/maintenance/test_dockerfile.sh runs its steps on Debian 11; docs/packaging.md states what has been run.
FROM ros:noetic-perception AS build
SHELL ["/bin/bash", "-eo", "pipefail", "-c"]
WORKDIR /workspace
COPY . src/corrsel
RUN apt-get update && rosdep update --rosdistro noetic && rosdep install --from-paths src --ignore-src --rosdistro noetic -y
RUN source /opt/ros/noetic/setup.bash && catkin_make -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX=/opt/corrsel install

FROM build AS test
RUN source devel/setup.bash && catkin_make tests && (cd build && ctest --output-on-failure)

FROM build
RUN rm -r build devel
ENTRYPOINT ["/bin/bash", "-c", "source /opt/corrsel/setup.bash -- && exec \"$@\"", "--"]
CMD ["bash"]
