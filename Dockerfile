# Three images, built from the Debian package:
#   docker build --target slim -t granuscope:slim .    HTML reports; the program paints pictures itself
#   docker build --target gl   -t granuscope:gl .      with OpenGL off-screen (OSMesa)
#   docker build --target pdf  -t granuscope .         with report.pdf, too (WeasyPrint)
# docker run --rm --user "$(id -u):$(id -g)" -v "$PWD:/data" granuscope run my.toml
FROM debian:12-slim AS build
SHELL ["/bin/bash", "-euo", "pipefail", "-c"]
WORKDIR /build
COPY packages.txt ./
COPY cmake/packages.sh cmake/
RUN . cmake/packages.sh && install_packages run --but weasyprint && apt-get install --yes --no-install-recommends dpkg-dev file
COPY . .
RUN cmake --preset unity && cmake --build --preset unity --target package

FROM debian:12-slim AS slim
COPY --from=build /build/build/unity/granuscope_*.deb /tmp/
RUN apt-get update \
  && apt-get install --yes --no-install-recommends /tmp/granuscope_*.deb \
  && rm -rf /tmp/granuscope_*.deb /var/lib/apt/lists/*
WORKDIR /data
ENTRYPOINT ["granuscope"]
CMD ["help"]

FROM slim AS gl
RUN apt-get update \
  && apt-get install --yes --no-install-recommends libosmesa6 \
  && rm -rf /var/lib/apt/lists/*

FROM gl AS pdf
RUN apt-get update \
  && apt-get install --yes --no-install-recommends weasyprint \
  && rm -rf /var/lib/apt/lists/*
