# Builds from this repository alone: docker build -t swarm-workbench .
# How to run it: docs/containers.md. tests/unit/test_containers.py lints it, and
# tests/containers runs its steps in a clean root.

FROM debian:12-slim AS build
# hadolint ignore=DL3008
RUN apt-get update \
    && apt-get install --yes --no-install-recommends \
        ca-certificates g++ gcc python3.11 python3.11-dev python3.11-venv \
    && rm -rf /var/lib/apt/lists/*
COPY . /opt/swarm-workbench
WORKDIR /opt/swarm-workbench
ENV PIP_NO_CACHE_DIR=1
RUN tools/bootstrap.sh && .venv/bin/swarm-setup

FROM debian:12-slim
# hadolint ignore=DL3008
RUN apt-get update \
    && apt-get install --yes --no-install-recommends python3.11 \
    && rm -rf /var/lib/apt/lists/* \
    && useradd --create-home --uid 1000 swarm
COPY --from=build --chown=swarm:swarm /opt/swarm-workbench /opt/swarm-workbench
WORKDIR /opt/swarm-workbench
USER 1000
ENV PATH=/opt/swarm-workbench/.venv/bin:$PATH
# Compiles the kernels once. Layers keep whole seconds of a file's time, by which numba knows it.
RUN find . -name '*.py' -exec touch --date=2024-01-01 {} + \
    && python -c "from swarm_nav.launch.warm_up import warm_up; warm_up()" \
    && mkdir runs
EXPOSE 8080
STOPSIGNAL SIGINT
CMD ["swarm-up", "--help"]
