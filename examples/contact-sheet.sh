#!/bin/sh
# Every plot and picture of a finished run at four sizes on one page, to be looked at:
#   contact-sheet.sh out/quick sheet        writes sheet/index.html
# granuscope must be in the PATH.
set -eu
run=$1 sheet=$2
mkdir -p "$sheet"
exec 3>"$sheet/index.html"
echo '<!doctype html><meta charset="utf-8"><title>Contact sheet</title><style>img { margin: 4px; vertical-align: top; border: 1px solid #ccc }</style>' >&3

# NAME FILE [FLAGS]: a pile or an ensemble, or in its place why there is no picture of it.
pictures() {
  name=$1 file=$2
  shift 2
  echo "<h2>$name</h2>" >&3
  for width in 400 800 1280 2000; do
    if granuscope render "$file" "$sheet/$name-$width.png" --width $width --dpi $((width / 7)) "$@" 2>"$sheet/log"; then
      echo "<img src='$name-$width.png'>" >&3
    else
      echo "<p>$(cat "$sheet/log")</p>" >&3
      return
    fi
  done
}

ids=$(granuscope figure "$run")
for id in $ids; do
  echo "<h2>$id</h2>" >&3
  for width in 86 120 178 260; do
    granuscope figure "$run" "$id" --format svg --width ${width}mm --font-size 8 --out "$sheet/$id-$width.svg" \
      >"$sheet/$id.txt" 2>"$sheet/log" || { cat "$sheet/log" >&2; exit 1; }
    echo "<img src='$id-$width.svg'>" >&3
  done
  echo "<p>$(cat "$sheet/$id.txt")</p>" >&3
done
for pile in "$run"/piles/*.h5; do
  for scene in forces weight friction; do
    pictures "$(basename "$pile" .h5)-$scene" "$pile" --scene $scene
  done
done
if [ -f "$run/piles/uniform.h5" ] && [ -f "$run/piles/overloaded.h5" ]; then
  pictures response "$run/piles/overloaded.h5" --scene response --minus "$run/piles/uniform.h5"
fi
for ensemble in "$run"/ensembles/*.h5; do
  pictures "mean-response-$(basename "$ensemble" .h5)" "$ensemble"
done
rm -f "$sheet/log"
echo "wrote $sheet/index.html"
