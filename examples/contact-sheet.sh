#!/bin/sh
# Every plot and pile of a finished run at four sizes on one page, to be looked at:
#   contact-sheet.sh out/quick sheet        writes sheet/index.html
set -eu
run=$1 sheet=$2
mkdir -p "$sheet"
exec 3>"$sheet/index.html"
echo '<!doctype html><meta charset="utf-8"><title>Contact sheet</title><style>img { margin: 4px; vertical-align: top; border: 1px solid #ccc }</style>' >&3
ids=$(granuscope figure "$run")
for id in $ids; do
  echo "<h2>$id</h2>" >&3
  for width in 86 120 178 260; do
    granuscope figure "$run" "$id" --format svg --width ${width}mm --font-size 8 --out "$sheet/$id-$width.svg" \
      >"$sheet/$id.txt" 2>"$sheet/log" || { cat "$sheet/log" >&2; exit 1; }
    echo "<img src='$id-$width.svg'>" >&3
  done
done
for pile in "$run"/piles/*.h5 "$run"/ensembles/*.h5; do
  name=$(basename "$pile" .h5)
  echo "<h2>$name</h2>" >&3
  for width in 400 800 1280 2000; do
    # Ensembles of models and of fluctuations alone have no mean response over the plane.
    granuscope render "$pile" "$sheet/$name-$width.png" --width $width --dpi $((width / 7)) 2>/dev/null || continue
    echo "<img src='$name-$width.png'>" >&3
  done
done
echo "wrote $sheet/index.html"
