// An experiment in shards, a task each, wherever Nextflow starts tasks; then the rows of all, the report, and the means of points.
//
//   nextflow run main.nf --experiment $PWD/lag.json --shards 8
//
// A file needs its whole path, since each task has a folder of its own. Results do not depend on the number of shards or machines.
nextflow.enable.dsl = 2

params.experiment = 'experiments/lockstep_loss' // or a file
params.shards = 8
params.laglab = 'laglab'
params.out = '.'

process shard {
    cpus 1

    input:
    val i

    output:
    path "${i}.csv"

    script:
    """
    ${params.laglab} sweep ${params.experiment} --shard ${i}/${params.shards} --jobs ${task.cpus} --out ${i}.csv
    """
}

process merge {
    publishDir params.out, mode: 'copy'

    input:
    path shards

    output:
    path 'rows.csv', emit: rows
    path 'report.html'

    script:
    """
    ${params.laglab} merge ${params.experiment} ${shards} --out rows.csv --report report.html
    """
}

process points {
    publishDir params.out, mode: 'copy'

    input:
    path rows

    output:
    path 'points.csv'

    script:
    """
    ${params.laglab} merge ${params.experiment} ${rows} --points --out points.csv
    """
}

workflow {
    shards = shard(Channel.of(1..params.shards))
    merge(shards.collect())
    points(merge.out.rows)
}
