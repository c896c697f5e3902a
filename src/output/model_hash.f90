!> Distinguishes models by hashes of their parts, so that a checkpoint of another model is rejected.
module model_hash
  use base_hash, only: hash_t
  use boundary, only: boundary_t
  use constraint, only: constraint_t
  use contact_pair, only: contact_t, assigned_law_t
  use mesh, only: block_t
  use model, only: model_t
  implicit none
  private
  public :: hash_model

  integer, parameter, public :: NPART = 9, CONSTANT_PART = 7, LOAD_PART = 8
  character(40), parameter, public :: PART(NPART) = [character(40) :: &
                                                     'the coordinates of nodes', &
                                                     'the nodes of elements', &
                                                     'the element types', &
                                                     'the material laws', &
                                                     'the supports', &
                                                     'the contacts', &
                                                     'the constants of materials or contacts', &
                                                     'the loads and prescribed motions', &
                                                     'the knots of splines or hanging nodes']

contains

  !> The hash of each PART of a model. Load tables are not included.
  pure subroutine hash_model(model, digits)
    type(model_t), intent(in) :: model
    character(16), intent(out) :: digits(NPART)
    type(hash_t) :: hash(NPART)
    integer :: b, i

    associate (mesh => model%mesh)
      do i = 1, size(mesh%xr, 2)
        call hash(1)%add(mesh%xr(:, i))
      end do
      do b = 1, size(mesh%block)
        associate (block => mesh%block(b))
          do i = 1, size(block%conn, 2)
            call hash(2)%add(block%conn(:, i))
          end do
          call hash(3)%add(trim(block%name)//' '//trim(block%row%name))
          call hash(3)%add([block%material, block%nelem, block%ext%degree])
          call hash(3)%add(pack(block%rule%xi, .true.))
          call hash(3)%add(block%rule%wgt)
          if (allocated(block%ext%w)) call hash(1)%add(pack(block%ext%w, .true.))
          call add_extraction(block, hash(9))
        end associate
      end do
      if (mesh%constraint%n > 0) call add_constraints(mesh%constraint, hash(9))
    end associate
    do i = 1, size(model%material)
      associate (m => model%material(i))
        call hash(4)%add(trim(m%row%name))
        call hash(4)%add([merge(1, 0, m%enhanced)])
        call hash(CONSTANT_PART)%add([m%prop, m%density])
      end associate
    end do
    do i = 1, size(model%eq, 2)
      call hash(5)%add(model%eq(:, i))
    end do
    do i = 1, size(model%contact)
      call add_contact(model%contact(i), hash(6), hash(CONSTANT_PART))
    end do
    call add_loads(model%bc, hash(LOAD_PART))
    do i = 1, NPART
      digits(i) = hash(i)%digits()
    end do
  end subroutine hash_model

  !> Add the operators of splines, which depend on their knots.
  pure subroutine add_extraction(block, hash)
    type(block_t), intent(in) :: block
    type(hash_t), intent(inout) :: hash
    integer :: i

    if (allocated(block%ext%op)) then
      do i = 1, size(block%ext%op)
        call hash%add(pack(block%ext%op(i)%c, .true.))
      end do
      call hash%add(pack(block%ext%iop, .true.))
    end if
    if (allocated(block%ext%surface)) then
      do i = 1, size(block%ext%surface)
        call hash%add(pack(block%ext%surface(i)%c, .true.))
      end do
      call hash%add(block%ext%isurface)
    end if
  end subroutine add_extraction

  !> Add the constraints of hanging nodes.
  pure subroutine add_constraints(list, hash)
    type(constraint_t), intent(in) :: list
    type(hash_t), intent(inout) :: hash
    integer :: last

    last = list%first(list%n + 1) - 1
    call hash%add(list%slave(:list%n))
    call hash%add(list%first(:list%n + 1))
    call hash%add(list%master(:last))
    call hash%add(list%c(:last))
  end subroutine add_constraints

  pure subroutine add_loads(bc, hash)
    type(boundary_t), intent(in) :: bc
    type(hash_t), intent(inout) :: hash
    integer :: i, j

    do i = 1, size(bc%value, 2)
      call hash%add(bc%value(:, i))
      call hash%add(bc%force(:, i))
      call hash%add(bc%table(:, i))
    end do
    do i = 1, size(bc%motion)
      associate (motion => bc%motion(i))
        call hash%add(motion%node)
        call hash%add(merge(1, 0, [motion%rotates, motion%acts]))
        call hash%add([motion%vector, motion%axis, motion%angle])
        call hash%add([motion%table])
      end associate
    end do
    do i = 1, size(bc%pressure)
      associate (pressure => bc%pressure(i))
        call hash%add(pressure%elem)
        call hash%add(pressure%side)
        call hash%add([pressure%value])
        call hash%add([pressure%table, merge(1, 0, pressure%follower)])
      end associate
    end do
    do i = 1, size(bc%dead)
      call hash%add(bc%dead(i)%node)
      do j = 1, size(bc%dead(i)%f, 2)
        call hash%add(bc%dead(i)%f(:, j))
      end do
      call hash%add([bc%dead(i)%table])
    end do
  end subroutine add_loads

  pure subroutine add_contact(contact, hash, constants)
    type(contact_t), intent(in) :: contact
    type(hash_t), intent(inout) :: hash, constants
    integer :: i, k

    call hash%add(contact%name)
    do k = 1, 2
      associate (side => contact%side(k))
        call hash%add([merge(1, 0, side%rigid), side%nelem])
        call hash%add(side%block)
        call hash%add(side%elem)
        call hash%add(side%face)
        call hash%add(side%node)
      end associate
    end do
    call hash%add([contact%scheme, merge(1, 0, [contact%on_pair, contact%balanced]), &
                   contact%ngauss, contact%ncell])
    call hash%add([contact%taper, contact%bond_gap])
    do i = 1, size(contact%bond)
      associate (bond => contact%bond(i))
        call hash%add(merge(1, 0, [bond%is_except, bond%is_box]))
        call hash%add([bond%a, bond%b])
      end associate
    end do
    call add_law(contact%normal, hash, constants)
    call add_law(contact%friction, hash, constants)
    call add_law(contact%cohesive, hash, constants)
    call constants%add([contact%after, contact%depth])
  end subroutine add_contact

  pure subroutine add_law(given, hash, constants)
    type(assigned_law_t), intent(in) :: given
    type(hash_t), intent(inout) :: hash, constants

    call hash%add([merge(1, 0, given%given)])
    if (.not. given%given) return
    call hash%add(trim(given%law%name)//' '//trim(given%law%option))
    call constants%add([given%prop, given%tau])
  end subroutine add_law

end module model_hash
