# The charts of docs/performance.md: FOLDER/NAME.csv becomes FOLDER/NAME.svg.
#     gnuplot -d -e "folder='examples/figures'" cmake/performance_charts.gp          (make -f Makefile.docs charts)
set encoding utf8
set datafile separator ','
set datafile commentschars '#'
set datafile missing NaN
set border 3
set tics nomirror
set grid ytics lc rgb '#e4e4e4'
set key samplen 1.5
file(name) = sprintf('%s/%s.csv', folder, name)
of(text, column) = strcol(1) eq text ? column : NaN

# One panel beside another: its left and right end as shares of the width.
left = 'set lmargin at screen 0.09; set rmargin at screen 0.48'
right = 'set lmargin at screen 0.59; set rmargin at screen 0.98'

# What an error costs.
set terminal svg size 760,360 dynamic background rgb 'white' font 'DejaVu Sans,11'
set output sprintf('%s/cost-for-equal-error.svg', folder)
array methods[6] = ["the paper's machine", 'NumPy', 'point', 'point coupled', 'multiplexed', 'fluctuation']
array colours[6] = ['#7f7f7f', '#e69f00', '#000000', '#0072b2', '#009e73', '#d55e00']
paper = 3461 * 180e-6 * 500 * 200  # s: piles, s a bead at three minutes for 1000 x 1000, beads
set multiplot
set tmargin at screen 0.8
set bmargin at screen 0.15
set logscale y
set format y '10^{%L}'
set xrange [0.08:0.42]
set yrange [0.1:3e7]
set xlabel 'friction coefficient μ'
set label 1 'the paper: 3461 piles' at 0.415, paper * 2.6 right textcolor rgb colours[1]
set key at screen 0.5, 0.99 center top maxrows 2
@left
set ylabel 'processor seconds for 1 % of c_0 − c'
plot for [k = 1:6] file('cost-for-equal-error') using 2:(of(methods[k], $3)) skip 1 with linespoints \
  lc rgb colours[k] lw 1.5 pt k + 3 ps 0.6 title methods[k], paper with lines lc rgb colours[1] dt 2 notitle
@right
set ylabel 'processor seconds for 1 % of D'
unset key
plot for [k = 1:6] file('cost-for-equal-error') using 2:(of(methods[k], $4)) skip 1 with linespoints \
  lc rgb colours[k] lw 1.5 pt k + 3 ps 0.6 notitle, paper with lines lc rgb colours[1] dt 2 notitle
unset multiplot
unset label 1

# How time grows with size.
set output sprintf('%s/time-with-size.svg', folder)
set terminal svg size 760,330 dynamic background rgb 'white' font 'DejaVu Sans,11'
ensemble(program, mu) = strcol(1) eq program && $2 == mu && $3 != $4
pile(mu) = strcol(1) eq 'granuscope' && $2 == mu && $3 == $4
light_blue = '#5fb4ea'  # of the smaller mu, as in the program's figures
set multiplot
set tmargin at screen 0.88
set bmargin at screen 0.16
set logscale xy
set format x '10^{%L}'
set xrange [3e4:2e9]
set yrange [0.03:100]
set key at graph 0.03, 0.99 left top Left reverse maxrows auto
set xlabel 'beads of all piles'
set ylabel 'processor seconds'
@left
plot file('time-with-size') using (ensemble('NumPy', 0.1) ? $3 * $4 * $5 : NaN):6 skip 1 with linespoints lc rgb colours[3] pt 5 ps 0.6 title 'NumPy, μ = 0.1', \
  '' using (ensemble('granuscope', 0.3) ? $3 * $4 * $5 : NaN):6 skip 1 with linespoints lc rgb colours[4] pt 6 ps 0.6 title 'granuscope, μ = 0.3', \
  '' using (ensemble('granuscope', 0.1) ? $3 * $4 * $5 : NaN):6 skip 1 with linespoints lc rgb light_blue pt 7 ps 0.6 title 'granuscope, μ = 0.1', \
  1e-8 * x with lines lc rgb '#7f7f7f' dt 2 title '10 ns a bead'
@right
unset logscale y
set format x '%g'
set format y '%g'
set xrange [50:5000]
set yrange [0:*]
set key at graph 0.97, 0.05 right bottom
set xtics (64, 125, 250, 500, 1000, 2000, 4000)
set xlabel 'layers and columns of a pile'
set ylabel 'processor ns per bead'
plot file('time-with-size') using (pile(0.3) ? $4 : NaN):(1e9 * $6 / ($3 * $4 * $5)) skip 1 with linespoints lc rgb colours[4] pt 6 ps 0.6 title 'μ = 0.3', \
  '' using (pile(0.1) ? $4 : NaN):(1e9 * $6 / ($3 * $4 * $5)) skip 1 with linespoints lc rgb light_blue pt 7 ps 0.6 title 'μ = 0.1'
unset multiplot
set xtics autofreq

# What a contact costs in a picture.
set output sprintf('%s/painting.svg', folder)
set terminal svg size 560,330 dynamic background rgb 'white' font 'DejaVu Sans,11'
array painters[4] = ['matplotlib', 'gnuplot', 'Cairo', 'granuscope']
array painter_colours[4] = ['#e69f00', '#7f7f7f', '#009e73', '#0072b2']
set lmargin at screen 0.14
set rmargin at screen 0.76
set tmargin at screen 0.95
set logscale xy
set format xy '10^{%L}'
set xrange [1e4:4e6]
set yrange [0.1:100]
set xlabel 'contacts painted'
set ylabel 'processor µs per contact'
set key at screen 0.78, 0.9 left top Left reverse maxrows auto
plot for [k = 1:4] file('painting') using 2:(of(painters[k], $3)) skip 1 with linespoints \
  lc rgb painter_colours[k] lw 1.5 pt k + 3 ps 0.6 title painters[k]
